// proto/WIRE.md agrees with the code: its examples are encoded and decoded, and its table of fields
// is compared.
#include "tests/unit/wire/wire_document.h"
#include "tests/unit/wire/wire_samples.h"
#include "shared/wire/field_table.h"
#include "shared/wire/packet.h"
#include "shared/wire/publication.h"
#include "shared/wire/seal.h"

#include <gtest/gtest.h>

#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace zoned::wire {
namespace {

using testing::Bytes;
using testing::document_lines;
using testing::Example;
using testing::examples;
using testing::state_in;
using testing::triple;

Vec3 vector(const Example& e, const std::string& key) {
    const auto all = e.numbers(key);
    EXPECT_EQ(all.size(), 3u) << e.line;
    return {static_cast<float>(all[0]), static_cast<float>(all[1]), static_cast<float>(all[2])};
}

/// `declared = 0 25`: field 0 has code 25; several in a row. `declared_text = 4 Ann`.
DeclaredPart declared_in(const Example& e,
                         const FieldSchema& fields,
                         std::vector<std::uint32_t>& words) {
    words.assign(fields.initial().begin(), fields.initial().end());
    DeclaredPart part{&fields, words, 0};
    const auto pairs = e.numbers("declared");
    for (std::size_t i = 0; i + 1 < pairs.size(); i += 2) {
        const auto field = static_cast<std::size_t>(pairs[i]);
        words[fields.fields()[field].word] = static_cast<std::uint32_t>(pairs[i + 1]);
        part.mask |= 1U << field;
    }
    std::istringstream in(e.text("declared_text"));
    std::size_t field = 0;
    std::string text;
    if (in >> field >> text) {
        const DeclaredField& at = fields.fields()[field];
        EXPECT_EQ(put_value(at, std::string_view(text), words_of(at, std::span(words))),
                  FieldOutcome::kDone);
        part.mask |= 1U << field;
    }
    return part;
}

void check_record(const Example& e) {
    const Quantization q;
    const bool upright = e.number("upright") != 0;
    const QuantizedState state = state_in(e, "");
    const QuantizedState reference = state_in(e, "reference.");
    RecordHead head;
    head.entity = EntityId(static_cast<std::uint32_t>(e.number("entity")));
    head.type = static_cast<TypeIndex>(e.number("type"));
    head.lod = static_cast<std::uint8_t>(e.number("lod"));
    head.keyframe = static_cast<std::uint8_t>(e.number("keyframe"));
    head.tick_low = static_cast<std::uint8_t>(e.number("tick_low"));
    const auto fields = testing::sample_fields();
    std::vector<std::uint32_t> words;
    const DeclaredPart declared = declared_in(e, *fields, words);
    Bytes out;
    if (e.name == "absolute") {
        encode_absolute(head, state, upright, q, out, declared);
    } else if (e.name == "delta") {
        encode_delta(head, state, reference, upright, q, out, declared);
    } else {
        encode_remove(head.entity, out);
    }
    EXPECT_EQ(out, e.bytes("hex"));

    RecordReader reader(out, q);
    const auto back = reader.next_head();
    ASSERT_TRUE(back.ok());
    EXPECT_EQ(back->entity, head.entity);
    if (back->kind != RecordKind::kRemove) {
        EXPECT_EQ(back->keyframe, head.keyframe);
        EXPECT_EQ(back->lod, head.lod);
        EXPECT_EQ(back->tick_low, head.tick_low);
        EXPECT_EQ(back->type, head.type);
        const auto read = back->kind == RecordKind::kAbsolute
                              ? reader.read_absolute(upright)
                              : reader.read_delta(reference, upright);
        ASSERT_TRUE(read.ok());
        EXPECT_EQ(*read, state);
        EXPECT_EQ(back->declared, declared.mask != 0);
        if (back->declared) {
            DeclaredUpdate update;
            ASSERT_EQ(reader.read_declared(fields.get(), update), DeclaredFault::kNone);
            std::vector<std::uint32_t> read_words(fields->initial().begin(),
                                                  fields->initial().end());
            apply_declared(*fields, update, read_words);
            EXPECT_EQ(update.mask, declared.mask);
            EXPECT_EQ(read_words, words);
        }
    }
    EXPECT_TRUE(reader.done());
}

void check_commands(const Example& e) {
    std::vector<motion::InputCommand> commands;
    const auto [first, last] = e.values.equal_range("command");
    for (auto it = first; it != last; ++it) {
        std::istringstream in(it->second);
        std::array<int, 5> v{};
        for (int& x : v) {
            in >> x;
        }
        commands.push_back({e.number("tick") + static_cast<Tick>(commands.size()),
                            static_cast<std::int8_t>(v[0]),
                            static_cast<std::int8_t>(v[1]),
                            static_cast<std::uint16_t>(v[2]),
                            static_cast<std::int16_t>(v[3]),
                            static_cast<std::uint16_t>(v[4])});
    }
    Bytes out;
    write_commands(commands, out);
    EXPECT_EQ(out, e.bytes("hex"));
    std::vector<motion::InputCommand> back;
    ASSERT_TRUE(read_commands(out, back).ok());
    EXPECT_EQ(back, commands);
}

void check_down_head(const Example& e) {
    DownHead head;
    head.tick = e.number("tick");
    head.zone = ZoneId(static_cast<std::uint16_t>(e.number("zone")));
    head.has_own = e.has("avatar");
    if (head.has_own) {
        head.own.avatar = EntityId(static_cast<std::uint32_t>(e.number("avatar")));
        head.own.input_tick = head.tick - e.number("age");
        head.own.input_missing = e.number("input_missing") != 0;
        head.own.input_lead = static_cast<std::int8_t>(e.number("input_lead"));
        head.own.state.grounded = e.number("grounded") != 0;
        head.own.state.yaw = static_cast<std::uint16_t>(e.number("yaw"));
        head.own.state.position = vector(e, "position");
        head.own.state.velocity = vector(e, "velocity");
    }
    if (e.has("widened")) {
        head.has_widened = true;
        head.widened = {static_cast<std::uint8_t>(e.number("widened")),
                        e.number("incomplete") != 0};
    }
    Bytes out;
    write_down_head(head, out);
    EXPECT_EQ(out, e.bytes("hex"));
    const auto back = read_down_head(out);
    ASSERT_TRUE(back.ok());
    EXPECT_EQ(back->head.zone, head.zone);
    EXPECT_EQ(back->head.own.input_tick, head.own.input_tick);
    EXPECT_EQ(back->records_offset, out.size());
}

void check_transport(const Example& e) {
    const auto ack = static_cast<std::uint16_t>(e.number("ack"));
    const auto bits = static_cast<std::uint32_t>(e.number("ack_bits"));
    const auto delay = static_cast<std::uint16_t>(e.number("ack_delay_10us"));
    Bytes out;
    if (e.name == "down-transport") {
        out.resize(kDownTransportBytes);
        const auto time = static_cast<std::uint32_t>(e.number("send_time_us"));
        write_transport(DownTransport{time, ack, bits, delay}, out.data());
    } else {
        out.resize(kUpTransportBytes);
        const auto one_way = static_cast<std::uint16_t>(e.number("one_way_128us"));
        write_transport(UpTransport{ack, bits, delay, one_way}, out.data());
    }
    EXPECT_EQ(out, e.bytes("hex"));
}

void check_datagram(const Example& e) {
    const auto sequence = static_cast<std::uint64_t>(e.number("sequence"));
    Bytes out(kDatagramHeaderBytes);
    write_datagram_header(
        {static_cast<std::uint32_t>(e.number("connection")), static_cast<std::uint16_t>(sequence)},
        out.data());
    if (e.name == "sealed-datagram") {
        SealKey key;
        const Bytes key_bytes = e.bytes("key");
        const Bytes salt_bytes = e.bytes("salt");
        ASSERT_EQ(key_bytes.size(), key.key.size());
        ASSERT_EQ(salt_bytes.size(), key.salt.size());
        std::copy(key_bytes.begin(), key_bytes.end(), key.key.begin());
        std::copy(salt_bytes.begin(), salt_bytes.end(), key.salt.begin());
        const Bytes header = out;
        Seal(key).seal(sequence, header, e.bytes("plain"), out);
    }
    EXPECT_EQ(out, e.bytes("hex"));
}

/// `value/width ...` packed as section "bit streams" says.
Bytes packed(const std::string& bits) {
    BitWriter writer;
    std::istringstream in(bits);
    std::uint32_t value = 0;
    char slash = 0;
    int width = 0;
    while (in >> value >> slash >> width) {
        writer.write(value, width);
    }
    Bytes out;
    writer.finish(out);
    return out;
}

TEST(WireDocument, HasExamplesThatTheCodeEncodesAndDecodesByteForByte) {
    const std::map<std::string, void (*)(const Example&)> checks{
        {"absolute", check_record},
        {"delta", check_record},
        {"remove", check_record},
        {"commands", check_commands},
        {"down-head", check_down_head},
        {"down-transport", check_transport},
        {"up-transport", check_transport},
        {"datagram-header", check_datagram},
        {"sealed-datagram", check_datagram}};
    // Checked by wire_doc_inputs_test.cpp, tests/unit/app/wire_doc_server_test.cpp and
    // tests/unit/client/wire_doc_fallback_test.cpp.
    const std::set<std::string> elsewhere{"character",
                                          "fallback",
                                          "first-datagram",
                                          "hello-frame",
                                          "input-window",
                                          "landing",
                                          "missing-inputs",
                                          "moves",
                                          "refused-frame"};
    std::map<std::string, int> seen;
    for (const Example& e : examples()) {
        if (e.name.starts_with("coded") || elsewhere.contains(e.name)) {
            continue;  // see coded_doc_test.cpp
        }
        SCOPED_TRACE("WIRE.md:" + std::to_string(e.line) + " " + e.name);
        ASSERT_TRUE(checks.contains(e.name));
        ASSERT_FALSE(e.bytes("hex").empty());
        checks.at(e.name)(e);
        if (e.has("bits")) {
            EXPECT_EQ(packed(e.text("bits")), e.bytes("hex"));
        }
        ++seen[e.name];
    }
    EXPECT_EQ(seen.size(), checks.size()) << "a kind of example is missing from the document";
}

std::string presence_text(Presence presence) {
    switch (presence) {
        case Presence::kAlways:
            return "always";
        case Presence::kMoving:
            return "moving";
        case Presence::kAccelerating:
            return "accelerating";
        case Presence::kFalling:
            return "ballistic";
        case Presence::kTurning:
            return "turning";
        case Presence::kUpright:
            return "upright";
        case Presence::kUprightMoving:
            return "upright, moving";
        case Presence::kTumbling:
            return "not upright";
        case Presence::kTumblingMoving:
            return "not upright, moving";
    }
    return "?";
}

std::string range_text(Range range) {
    switch (range) {
        case Range::kMotion:
            return "0..5";
        case Range::kLeftOut:
            return "0..3";
        case Range::kHorizontal:
            return "±horizontal";
        case Range::kVertical:
            return "±vertical";
        case Range::kVelocity:
            return "±velocity";
        case Range::kAcceleration:
            return "±acceleration";
        case Range::kAngularVelocity:
            return "±angular";
        case Range::kYaw:
            return "0..2^yaw_bits-1, wraps";
        case Range::kSmallestThree:
            return "±limit";
        case Range::kAppearance:
            return "0..65535";
    }
    return "?";
}

std::string classes_text(const SizeClasses& classes) {
    std::string out;
    for (int k = 0; k < classes.count; ++k) {
        out += (k == 0 ? "" : " ");
        out += classes.bits[k] == kFull ? "full" : std::to_string(classes.bits[k]);
    }
    return out;
}

TEST(WireDocument, PrintsTheTableOfFieldsThatTheCodeFollows) {
    std::vector<std::string> expected{
        "| field | components | unit | present | range | absolute classes | delta classes | full "
        "bits |",
        "|---|---|---|---|---|---|---|---|"};
    const FieldLayout layout{Quantization{}};
    for (const Field& f : kFields) {
        std::ostringstream row;
        row << "| " << f.name << " | " << int{f.components} << " | " << f.unit << " | "
            << presence_text(f.presence) << " | " << range_text(f.range) << " | "
            << classes_text(f.absolute) << " | " << classes_text(f.delta) << " | "
            << layout[f.range].full_bits << " |";
        expected.push_back(row.str());
    }
    std::vector<std::string> printed;
    bool inside = false;
    for (const std::string& line : document_lines()) {
        if (line.starts_with("<!-- fields")) {
            inside = true;
        } else if (inside && line.starts_with("|")) {
            printed.push_back(line);
        } else {
            inside = false;
        }
    }
    EXPECT_EQ(printed, expected);
}

TEST(FieldTable, IsFitForTheCodec) {
    ASSERT_EQ(kFields[0].range, Range::kMotion) << "the others ask for it";
    std::array<int, kColumns> upright{};
    std::array<int, kColumns> tumbling{};
    for (const Field& f : kFields) {
        for (const SizeClasses& c : {f.absolute, f.delta}) {
            EXPECT_TRUE(c.count == 1 || c.count == 2 || c.count == 4) << f.name;
            EXPECT_EQ(c.bits[c.count - 1], kFull) << f.name;
            for (int k = 1; k < c.count; ++k) {
                EXPECT_LT(c.bits[k - 1], c.bits[k]) << f.name;
            }
        }
        for (int c = f.first; c < f.first + f.components; ++c) {
            upright[c] += is_present(f.presence, Motion::kTurning, true) ? 1 : 0;
            tumbling[c] += is_present(f.presence, Motion::kTurning, false) ? 1 : 0;
        }
    }
    // A tumbling body that turns sends every column but the floor once, an upright one all but the
    // rest of its orientation and the spin about x and z.
    for (int c = 0; c < 21; ++c) {
        EXPECT_EQ(tumbling[c], 1) << c;
        const bool left_out = c == 11 || c == 12 || c == 13 || c == 14 || c == 15;
        EXPECT_EQ(upright[c], left_out ? 0 : 1) << c;
    }
    // A falling body has a floor, and gravity for an acceleration.
    for (const Field& f : kFields) {
        const bool of_floor = f.first == 21;
        const bool of_acceleration = f.first >= 7 && f.first < 10;
        EXPECT_FALSE(of_floor && is_present(f.presence, Motion::kTurning, false));
        if (of_floor || of_acceleration) {
            EXPECT_EQ(is_present(f.presence, Motion::kBallistic, false), of_floor) << f.name;
        }
    }
}

}  // namespace
}  // namespace zoned::wire
