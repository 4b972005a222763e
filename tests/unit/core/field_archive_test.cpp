#include "shared/core/archive/field_archive.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

namespace zoned::core {
namespace {

enum class Colour : std::uint8_t {
    kRed,
    kBlue,
};

struct DensePart {
    float x = 1.0F;
    std::uint32_t y = 2;
    Colour colour = Colour::kBlue;
    std::uint8_t shade = 3;
    std::uint16_t more = 4;
};

struct LoosePart {
    bool on = true;
    std::string text = "text";
    std::vector<DensePart> parts = {DensePart(), DensePart()};
    std::array<std::uint16_t, 3> three{1, 2, 3};

    friend bool operator==(const LoosePart& a, const LoosePart& b) {
        return a.on == b.on && a.text == b.text && a.parts.size() == b.parts.size() &&
               a.three == b.three;
    }
};

class Listed {
  public:
    explicit Listed(int secret = 0) : secret_(secret) {}

    template <class Archive>
    void serialize(Archive& archive) {
        archive(secret_, unique_, maybe_, map_);
    }

    void fill() {
        unique_ = std::make_unique<LoosePart>();
        unique_->text = "unique";
        maybe_ = 2.5;
        map_ = {{EntityId(1), "one"}, {EntityId(7), "seven"}};
    }

    [[nodiscard]] bool same(const Listed& other) const {
        return secret_ == other.secret_ && *unique_ == *other.unique_ && maybe_ == other.maybe_ &&
               map_ == other.map_;
    }

  private:
    int secret_ = 0;
    std::unique_ptr<LoosePart> unique_;
    std::optional<double> maybe_;
    std::map<EntityId, std::string> map_;
};

static_assert(count_fields<DensePart>() == 5);
static_assert(count_fields<LoosePart>() == 4);
static_assert(is_dense<DensePart>());
static_assert(!is_dense<LoosePart>());
static_assert(!is_dense<bool>(), "a byte of 2 is no bool");

std::vector<std::uint8_t> listed_bytes() {
    Listed listed(-5);
    listed.fill();
    std::vector<std::uint8_t> bytes;
    FieldWriter write(bytes);
    write.section("all", [&] { write(listed); });
    return bytes;
}

TEST(FieldArchive, GivesBackPlainStructsClassesAndContainers) {
    Listed listed(-5);
    listed.fill();
    const std::vector<std::uint8_t> bytes = listed_bytes();
    Listed again;
    FieldReader read(bytes);
    read.section("all", [&] { read(again); });
    EXPECT_EQ(read.wrong(), "");
    EXPECT_EQ(read.left(), 0U);
    EXPECT_TRUE(listed.same(again));
}

TEST(FieldArchive, WritesNumbersInLittleEndian) {
    std::vector<std::uint8_t> bytes;
    FieldWriter write(bytes);
    write(std::uint32_t{0x01020304}, EntityId(5), true);
    EXPECT_EQ(bytes, (std::vector<std::uint8_t>{4, 3, 2, 1, 5, 0, 0, 0, 1}));
}

TEST(FieldArchive, RefusesEveryCutWithItsPlace) {
    const std::vector<std::uint8_t> bytes = listed_bytes();
    for (std::size_t size = 0; size < bytes.size(); ++size) {
        Listed again;
        const std::span<const std::uint8_t> cut(bytes.data(), size);
        FieldReader read(cut);
        read.section("all", [&] { read(again); });
        EXPECT_EQ(read.wrong().substr(0, 5), "all: ") << size;
    }
}

TEST(FieldArchive, TakesNoMemoryForListsThatAreLongerThanTheirBytes) {
    std::vector<std::uint8_t> bytes;
    FieldWriter write(bytes);
    write(~std::uint64_t{0} / 2);
    std::vector<DensePart> dense;
    FieldReader read_dense(bytes);
    read_dense(dense);
    EXPECT_FALSE(read_dense.good());
    EXPECT_TRUE(dense.empty());
    std::vector<LoosePart> loose;
    FieldReader read_loose(bytes);
    read_loose(loose);
    EXPECT_FALSE(read_loose.good());
    EXPECT_TRUE(loose.empty());
}

TEST(FieldArchive, RefusesKeysInNoOrderAndPartsThatAreTooLong) {
    std::vector<std::uint8_t> bytes;
    FieldWriter write(bytes);
    write(std::uint64_t{2}, EntityId(7), EntityId(1));
    std::set<EntityId> keys;
    FieldReader read(bytes);
    read(keys);
    EXPECT_EQ(read.wrong(), "keys are in no order");

    bytes.clear();
    FieldWriter longer(bytes);
    longer.section("part", [&] { longer(std::uint32_t{1}, std::uint32_t{2}); });
    std::uint32_t one = 0;
    FieldReader half(bytes);
    half.section("part", [&] { half(one); });
    EXPECT_EQ(half.wrong(), "part: 4 bytes are left over");
}

TEST(FieldArchive, LendsTheLastOfAType) {
    std::vector<std::uint8_t> bytes;
    FieldWriter writer(bytes);
    int first = 1;
    double other = 2.0;
    int second = 3;
    writer.lend(first);
    writer.lend(other);
    writer.lend(second);
    EXPECT_EQ(&writer.lent<int>(), &second);
    EXPECT_EQ(&writer.lent<double>(), &other);
}

}  // namespace
}  // namespace zoned::core
