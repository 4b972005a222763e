#include "shared/wire/widening.h"

#include "shared/wire/packet.h"

#include <gtest/gtest.h>

#include <vector>

namespace zoned::wire {
namespace {

TEST(Widening, DoublesTheFarthestLevelFirst) {
    EXPECT_EQ(widening(0, 0, 3), 1.0);
    EXPECT_EQ(widening(0, 2, 3), 1.0);
    EXPECT_EQ(widening(1, 2, 3), 2.0);
    EXPECT_EQ(widening(1, 1, 3), 1.0);
    EXPECT_EQ(widening(2, 1, 3), 2.0);
    EXPECT_EQ(widening(2, 0, 3), 1.0);
    EXPECT_EQ(widening(3, 0, 3), 2.0);
    EXPECT_EQ(widening(4, 2, 3), 4.0);
    EXPECT_EQ(widening(4, 0, 3), 2.0);
}

TEST(Widening, NeverNarrowsFromStepToStep) {
    for (std::size_t lods = 1; lods <= 4; ++lods) {
        for (std::size_t lod = 0; lod < lods; ++lod) {
            for (std::uint8_t step = 1; step <= kMostWidening; ++step) {
                EXPECT_GE(widening(step, lod, lods), widening(step - 1, lod, lods));
            }
            const std::uint8_t step = widening_for(5.0, lod, lods);
            EXPECT_GE(widening(step, lod, lods), 5.0);
            EXPECT_LT(widening(step - 1, lod, lods), 5.0);
        }
    }
    EXPECT_EQ(widening_for(1e30, 0, 4), kNoBound);
}

TEST(Widening, IsRewrittenInPlaceWhateverTheZone) {
    for (const std::uint16_t zone : {1, 31, 32, 4095, 4096, 65535}) {
        DownHead head;
        head.tick = 77;
        head.zone = ZoneId(zone);
        head.has_widened = true;
        std::vector<std::uint8_t> body;
        write_down_head(head, body);
        rewrite_widened({7, true}, body);
        const auto parsed = read_down_head(body);
        ASSERT_TRUE(parsed.ok());
        EXPECT_EQ(parsed->head.zone.value, zone);
        EXPECT_EQ(parsed->head.widened, (Widened{7, true}));
        EXPECT_EQ(parsed->records_offset, body.size());
        for (const std::uint8_t step : {41, 62}) {
            rewrite_widened({step, false}, body);
            EXPECT_FALSE(read_down_head(body).ok());
        }
        body.back() = 0x80;
        EXPECT_FALSE(read_down_head(body).ok());
    }
}

}  // namespace
}  // namespace zoned::wire
