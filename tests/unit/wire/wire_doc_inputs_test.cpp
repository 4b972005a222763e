// proto/WIRE.md agrees with the code about a session's beginning, what commands do, and landings.
#include "client-sim/link/client.h"
#include "tests/unit/wire/wire_document.h"
#include "shared/motion/apply_input.h"
#include "shared/motion/dead_reckoning.h"
#include "shared/wire/packet.h"
#include "shared/wire/seal.h"
#include "shared/wire/session/session_messages.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>
#include <string>
#include <vector>

namespace zoned::wire {
namespace {

using testing::Bytes;
using testing::Example;
using testing::examples_named;

/// All lines of one key, in the order of the page.
std::vector<std::string> lines_of(const Example& e, const std::string& key) {
    std::vector<std::string> out;
    const auto [first, last] = e.values.equal_range(key);
    for (auto it = first; it != last; ++it) {
        out.push_back(it->second);
    }
    return out;
}

std::vector<float> floats(const std::string& text) {
    std::istringstream in(text);
    std::vector<float> out;
    for (float f = 0.0F; in >> f;) {
        out.push_back(f);
    }
    return out;
}

/// A frame as it lies in the stream.
Bytes with_length(const Bytes& message) {
    Bytes out;
    for (std::size_t shift = 0; shift < 32; shift += 8) {
        out.push_back(static_cast<std::uint8_t>(message.size() >> shift));
    }
    out.insert(out.end(), message.begin(), message.end());
    return out;
}

Bytes client_frame(const ClientMessage& message) {
    Bytes encoded;
    encode_message(message, encoded);
    return with_length(encoded);
}

SealKey key_in(const Example& e) {
    SealKey key;
    const Bytes key_bytes = e.bytes("key");
    const Bytes salt_bytes = e.bytes("salt");
    EXPECT_EQ(key_bytes.size(), key.key.size());
    EXPECT_EQ(salt_bytes.size(), key.salt.size());
    std::copy_n(key_bytes.begin(), key.key.size(), key.key.begin());
    std::copy_n(salt_bytes.begin(), key.salt.size(), key.salt.begin());
    return key;
}

TEST(WireDocument, SaysTheProtocolVersionInWordsAndInHello) {
    const std::string line = "The protocol version is ";
    int said = 0;
    for (const std::string& text : testing::document_lines()) {
        if (text.starts_with(line)) {
            EXPECT_EQ(std::stoul(text.substr(line.size())), link::kProtocolVersion) << text;
            ++said;
        }
    }
    EXPECT_EQ(said, 1);
    const auto all = examples_named("hello-frame");
    ASSERT_EQ(all.size(), 1U);
    const Example& e = all[0];
    HelloMessage hello;
    hello.protocol_version = link::kProtocolVersion;
    hello.name = e.text("name");
    EXPECT_EQ(e.number("protocol_version"), hello.protocol_version);
    EXPECT_EQ(client_frame({hello}), e.bytes("hex"));
}

TEST(WireDocument, SealsTheFirstDatagramOfAClientAsTheCodeDoes) {
    const auto all = examples_named("first-datagram");
    ASSERT_EQ(all.size(), 1U);
    const Example& e = all[0];
    const auto sequence = static_cast<std::uint64_t>(e.number("sequence"));
    Bytes plain(kUpTransportBytes);
    write_transport(UpTransport{}, plain.data());
    EXPECT_EQ(plain, e.bytes("plain"));
    Bytes datagram(kDatagramHeaderBytes);
    write_datagram_header(
        {static_cast<std::uint32_t>(e.number("connection")), static_cast<std::uint16_t>(sequence)},
        datagram.data());
    const Bytes header = datagram;
    Seal(key_in(e)).seal(sequence, header, plain, datagram);
    EXPECT_EQ(datagram, e.bytes("hex"));
    const DatagramMessage inside{{datagram.begin(), datagram.end()}};
    EXPECT_EQ(client_frame({inside}), e.bytes("frame"));
}

/// `command = move_x move_z yaw pitch buttons`, of consecutive ticks.
std::vector<motion::InputCommand> commands_in(const Example& e) {
    std::vector<motion::InputCommand> out;
    for (const std::string& line : lines_of(e, "command")) {
        std::istringstream in(line);
        std::array<int, 5> v{};
        for (int& x : v) {
            in >> x;
        }
        out.push_back({e.number("tick") + static_cast<Tick>(out.size()),
                       static_cast<std::int8_t>(v[0]),
                       static_cast<std::int8_t>(v[1]),
                       static_cast<std::uint16_t>(v[2]),
                       static_cast<std::int16_t>(v[3]),
                       static_cast<std::uint16_t>(v[4])});
    }
    return out;
}

/// `x y z vx vy vz` and whether it stands on ground.
motion::CharacterState character_in(const std::string& line) {
    const std::vector<float> v = floats(line);
    motion::CharacterState state;
    EXPECT_EQ(v.size(), 7U) << line;
    if (v.size() == 7) {
        state.position = {v[0], v[1], v[2]};
        state.velocity = {v[3], v[4], v[5]};
        state.grounded = v[6] != 0.0F;
    }
    return state;
}

std::string text_of(const motion::CharacterState& state) {
    std::ostringstream out;
    out.precision(9);
    out << state.position.transpose() << ' ' << state.velocity.transpose() << ' '
        << int{state.grounded};
    return out.str();
}

/// The character of all examples: the default limits, on the ground plane at height 0.
void check_moves(const Example& e) {
    const auto commands = commands_in(e);
    const auto after = lines_of(e, "after");
    ASSERT_FALSE(commands.empty());
    ASSERT_EQ(commands.size(), after.size());
    Bytes body;
    write_commands(commands, body);
    EXPECT_EQ(body, e.bytes("hex"));
    const motion::StaticGeometry plane({}, 0.0F);
    const auto dt = static_cast<float>(1.0 / static_cast<double>(e.number("tick_rate_hz")));
    motion::CharacterState state = character_in(e.text("before"));
    for (std::size_t i = 0; i < commands.size(); ++i) {
        state = motion::apply_input(state, commands[i], motion::CharacterLimits{}, plane, dt);
        const motion::CharacterState said = character_in(after[i]);
        EXPECT_TRUE(state.position == said.position && state.velocity == said.velocity &&
                    state.grounded == said.grounded)
            << "after command " << i << " the code has " << text_of(state);
        EXPECT_EQ(state.yaw, commands[i].yaw);
    }
}

TEST(WireDocument, MovesCharactersToTheBitAsTheCodeDoes) {
    const auto all = examples_named("moves");
    EXPECT_GE(all.size(), 4U);
    for (const Example& e : all) {
        SCOPED_TRACE("WIRE.md:" + std::to_string(e.line));
        check_moves(e);
    }
}

TEST(WireDocument, SaysTheLimitsOfTheCharacterOfItsExamples) {
    const motion::CharacterLimits limits;
    const auto all = examples_named("character");
    ASSERT_EQ(all.size(), 1U);
    const std::vector<std::pair<std::string, float>> expected{
        {"radius", limits.radius},
        {"half_segment", limits.half_segment},
        {"speed", limits.speed},
        {"sprint_factor", limits.sprint_factor},
        {"acceleration", limits.acceleration},
        {"air_acceleration", limits.air_acceleration},
        {"jump_speed", limits.jump_speed},
        {"gravity", limits.gravity}};
    EXPECT_EQ(all[0].values.size(), expected.size());
    for (const auto& [name, value] : expected) {
        ASSERT_EQ(all[0].numbers(name).size(), 1U) << name;
        EXPECT_EQ(static_cast<float>(all[0].numbers(name)[0]), value) << name;
    }
}

/// Where a falling entity is `t` seconds after its publication: `at = t x y z`.
void check_landing(const Example& e) {
    const Quantization q;
    QuantizedState sent;
    sent.at_rest = false;
    sent.order = motion::PredictorOrder::kBallistic;
    sent.position = testing::triple(e, "position");
    sent.velocity = testing::triple(e, "velocity");
    sent.floor = static_cast<std::int32_t>(e.number("floor_y"));
    const motion::KinematicState from = dequantize(sent, true, q);
    EXPECT_NEAR(motion::landing_time(from), e.numbers("landing_s").at(0), 5e-7);
    for (const std::string& line : lines_of(e, "at")) {
        const std::vector<float> v = floats(line);
        ASSERT_EQ(v.size(), 4U) << line;
        const Vec3 there = motion::predict_position(from, sent.order, v[0]);
        EXPECT_LT((there - Vec3(v[1], v[2], v[3])).norm(), 1e-5F) << line << ": " << there;
    }
    if (e.has("ground")) {
        const motion::CharacterLimits limits;
        const double centre = e.numbers("ground")[0] + static_cast<double>(limits.radius) +
                              static_cast<double>(limits.half_segment);
        EXPECT_EQ(sent.floor, std::lround(centre / static_cast<double>(q.position_step_m)));
    }
}

TEST(WireDocument, LandsFallingEntitiesAsTheCodeDoes) {
    const auto all = examples_named("landing");
    EXPECT_EQ(all.size(), 2U);
    for (const Example& e : all) {
        SCOPED_TRACE("WIRE.md:" + std::to_string(e.line));
        check_landing(e);
    }
}

}  // namespace
}  // namespace zoned::wire
