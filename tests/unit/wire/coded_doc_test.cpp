// The packets of coded records in proto/WIRE.md agree with the code's reader and writer.
#include "tests/unit/wire/wire_document.h"
#include "tests/unit/wire/wire_samples.h"
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

/// One entity whose records say `declared`, pairs of a field and its code.
struct DeclaredInDocument final : record::DeclaredSource {
    explicit DeclaredInDocument(const FieldSchema& schema)
        : fields(schema),
          words(schema.initial().begin(), schema.initial().end()),
          changed(schema.fields().size(), 0) {}

    void follow(const Example& e) {
        const auto pairs = e.numbers("declared");
        for (std::size_t i = 0; i + 1 < pairs.size(); i += 2) {
            const auto field = static_cast<std::size_t>(pairs[i]);
            words[fields.fields()[field].word] = static_cast<std::uint32_t>(pairs[i + 1]);
            changed[field] = e.number("tick");
        }
    }

    [[nodiscard]] record::DeclaredValues declared_of(EntityId /*entity*/) const override {
        return {words, changed};
    }

    const FieldSchema& fields;
    std::vector<std::uint32_t> words;
    std::vector<Tick> changed;
};

TEST(WireDocument, HasCodedPacketsWithDeclaredFields) {
    const auto fields = testing::sample_fields();
    FieldSchemas by_type(4);
    by_type[3] = fields;
    const record::RecordFormat format(Quantization{}, 1.0F / 30.0F, by_type);
    record::RecordEncoder encoder(format);
    record::RecordDecoder decoder(format);
    DeclaredInDocument world(*fields);
    std::vector<std::uint32_t> known;
    int packets = 0;
    for (const Example& e : examples()) {
        if (e.name != "coded-declared") {
            continue;
        }
        SCOPED_TRACE("WIRE.md:" + std::to_string(e.line));
        world.follow(e);
        const auto number = static_cast<entropy::PacketNumber>(e.number("packet"));
        const std::vector<record::CodedRecord> records{coded_record(e.text("record"))};
        for (const double acknowledged : e.numbers("acknowledged")) {
            encoder.acknowledge(static_cast<entropy::PacketNumber>(acknowledged));
        }
        Bytes out;
        encoder.sent(
            encoder.encode(number, e.number("tick"), ZoneId(3), records, out, false, &world));
        EXPECT_EQ(out, e.bytes("hex"));
        const auto frame = decoder.decode(number, e.number("tick"), ZoneId(3), e.bytes("hex"));
        ASSERT_TRUE(frame) << frame.error();
        expect_same((*frame)->records[0], records[0]);
        apply_declared(*fields, (*frame)->declared.at(0), known);
        EXPECT_EQ(known, world.words);
        ++packets;
    }
    EXPECT_EQ(packets, 2);
}

}  // namespace
}  // namespace zoned::wire
