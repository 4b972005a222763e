// The packets of coded records in proto/WIRE.md agree with the code's reader and writer.
#include "tests/unit/wire/wire_document.h"
#include "shared/wire/record/record_codec.h"

#include <cctype>

namespace zoned::wire {
namespace {

using testing::Bytes;
using testing::Example;
using testing::examples;
using testing::state_in;

/// A line of a coded packet: words, each with its numbers; words not mentioned are 0.
record::CodedRecord coded_record(const std::string& line) {
    std::istringstream in(line);
    Example row;
    std::string word, key, kind;
    in >> kind >> word;
    for (std::string token; in >> token;) {
        const bool is_key = std::isalpha(static_cast<unsigned char>(token[0])) != 0;
        if (is_key) {
            key = token;
            row.values.emplace(key, "");
        } else if (!key.empty()) {
            row.values.find(key)->second += token + " ";
        }
    }
    record::CodedRecord r;
    r.entity = EntityId(static_cast<std::uint32_t>(std::stoul(word)));
    r.remove = kind == "remove";
    if (!r.remove) {
        r.lod = static_cast<std::uint8_t>(row.number("lod"));
        r.type = static_cast<TypeIndex>(row.number("type"));
        r.upright = row.has("upright");
        r.tick = row.number("tick");
        r.state = state_in(row, "");
    }
    return r;
}

void expect_same(const record::CodedRecord& a, const record::CodedRecord& b) {
    EXPECT_EQ(a.entity, b.entity);
    ASSERT_EQ(a.remove, b.remove);
    if (!a.remove) {
        EXPECT_EQ(a.lod, b.lod);
        EXPECT_EQ(a.type, b.type);
        EXPECT_EQ(a.upright, b.upright);
        EXPECT_EQ(a.tick, b.tick);
        EXPECT_EQ(a.state, b.state);
    }
}

/// The listed values, if any, encode to the listed bytes.
bool check_listing(const Example& e) {
    if (!e.has("code")) {
        return false;
    }
    Bytes out;
    entropy::RangeEncoder coder(out);
    std::istringstream in(e.text("code"));
    std::uint32_t a = 0, n = 0;
    for (char between = 0; in >> a >> between >> n;) {
        if (between == '/') {
            coder.encode_raw(a, static_cast<int>(n));
        } else {
            coder.encode(a, n);
        }
    }
    coder.finish();
    EXPECT_EQ(out, e.bytes("hex"));
    return true;
}

TEST(WireDocument, HasAStreamOfCodedPacketsThatTheCodeEncodesAndDecodes) {
    const record::RecordFormat format(Quantization{}, 1.0F / 30.0F);
    record::RecordEncoder encoder(format);
    record::RecordDecoder missing_some(format);
    record::RecordDecoder missing_none(format);
    int packets = 0, lost = 0, listings = 0;
    for (const Example& e : examples()) {
        if (e.name != "coded") {
            continue;
        }
        SCOPED_TRACE("WIRE.md:" + std::to_string(e.line));
        const auto number = static_cast<entropy::PacketNumber>(e.number("packet"));
        const ZoneId zone(static_cast<std::uint16_t>(e.number("zone")));
        std::vector<record::CodedRecord> records;
        const auto [first, last] = e.values.equal_range("record");
        for (auto it = first; it != last; ++it) {
            records.push_back(coded_record(it->second));
        }
        if (e.has("resets")) {
            encoder.start_over();
        }
        for (const double acknowledged : e.numbers("acknowledged")) {
            encoder.acknowledge(static_cast<entropy::PacketNumber>(acknowledged));
        }
        listings += check_listing(e) ? 1 : 0;
        Bytes out;
        encoder.sent(encoder.encode(number, e.number("tick"), zone, records, out));
        EXPECT_EQ(out, e.bytes("hex"));
        for (record::RecordDecoder* decoder : {&missing_some, &missing_none}) {
            if (e.has("lost") && decoder == &missing_some) {
                ++lost;
                continue;
            }
            const auto frame = decoder->decode(number, e.number("tick"), zone, e.bytes("hex"));
            ASSERT_TRUE(frame) << frame.error();
            ASSERT_EQ((*frame)->records.size(), records.size());
            for (std::size_t i = 0; i < records.size(); ++i) {
                expect_same((*frame)->records[i], records[i]);
            }
        }
        ++packets;
    }
    EXPECT_GE(packets, 3);
    EXPECT_GE(lost, 1);
    EXPECT_GE(listings, 1);
}

}  // namespace
}  // namespace zoned::wire
