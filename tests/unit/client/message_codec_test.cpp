// The codec of the session's messages against the protobuf library, which the server uses.
#include "tests/fuzz/message_agreement.h"
#include "tests/fuzz/random_message.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace zoned::wire {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes bytes_of_message(const google::protobuf::Message& message) {
    const std::string bytes = message.SerializeAsString();
    return {bytes.begin(), bytes.end()};
}

/// A message of either direction with random content, as protobuf writes it.
Bytes random_message(core::Rng& rng) {
    proto::ServerMessage down;
    proto::ClientMessage up;
    google::protobuf::Message& message =
        rng.below(3) == 0 ? static_cast<google::protobuf::Message&>(up) : down;
    test::fill_randomly(message, rng);
    return bytes_of_message(message);
}

TEST(MessageCodec, ReadsAndWritesTheBytesOfProtobuf) {
    core::Rng rng(7);
    std::size_t bytes = 0;
    for (int i = 0; i < 3000; ++i) {
        const Bytes message = random_message(rng);
        bytes += message.size();
        ASSERT_EQ(test::any_disagreement(message), "") << "message " << i;
    }
    EXPECT_GT(bytes, 250'000U) << "the messages hold something";
}

TEST(MessageCodec, ReadsEachFieldOfAWorld) {
    core::Rng rng(3);
    for (int i = 0; i < 300; ++i) {
        proto::ServerMessage message;
        test::fill_randomly(*message.mutable_welcome()->mutable_world(), rng);
        ASSERT_EQ(test::any_disagreement(bytes_of_message(message)), "") << "world " << i;
    }
}

TEST(MessageCodec, RefusesAndAcceptsDamagedBytesAsProtobufDoes) {
    core::Rng rng(11);
    for (int i = 0; i < 20'000; ++i) {
        Bytes message = random_message(rng);
        for (std::uint32_t n = 1 + rng.below(3); n > 0 && !message.empty(); --n) {
            const std::size_t at = rng.below(static_cast<std::uint32_t>(message.size()));
            switch (rng.below(3)) {
                case 0:
                    message[at] = static_cast<std::uint8_t>(rng.below(256));
                    break;
                case 1:
                    message.resize(at);
                    break;
                default:
                    message.insert(message.begin() + static_cast<std::ptrdiff_t>(at),
                                   static_cast<std::uint8_t>(rng.below(256)));
            }
        }
        ASSERT_EQ(test::any_disagreement(message), "") << "damage " << i;
    }
}

TEST(MessageCodec, RefusesAndAcceptsAnyShortBytesAsProtobufDoes) {
    core::Rng rng(13);
    for (int i = 0; i < 200'000; ++i) {
        Bytes bytes(rng.below(12));
        // Small numbers are tags of known fields.
        std::generate(bytes.begin(), bytes.end(), [&] {
            return static_cast<std::uint8_t>(rng.below(2) == 0 ? rng.below(128) : rng.below(256));
        });
        ASSERT_EQ(test::any_disagreement(bytes), "") << "bytes " << i;
    }
}

TEST(MessageCodec, PassesOverFieldsOfALaterVersion) {
    proto::ServerMessage message;
    message.mutable_joined()->set_avatar(9);
    google::protobuf::UnknownFieldSet& later =
        *message.mutable_joined()->GetReflection()->MutableUnknownFields(message.mutable_joined());
    later.AddVarint(1000, 5);
    later.AddFixed32(1001, 5);
    later.AddFixed64(1002, 5);
    later.AddLengthDelimited(1003, "later");
    later.AddGroup(1004)->AddGroup(7)->AddVarint(1, 2);
    ServerMessage read;
    ASSERT_TRUE(decode_message(bytes_of_message(message), read));
    ASSERT_TRUE(std::holds_alternative<JoinedMessage>(read.message));
    EXPECT_EQ(std::get<JoinedMessage>(read.message).avatar, 9U);
}

TEST(MessageCodec, RefusesGroupsWithoutEnd) {
    Bytes deep;
    for (int i = 0; i < 1'000'000; ++i) {
        deep.push_back(0x7B);  // a group in a group in a group
    }
    ServerMessage read;
    EXPECT_FALSE(decode_message(deep, read));
}

TEST(MessageCodec, RefusesMoreElementsThanAnyWorldHas) {
    Bytes zones;
    for (std::size_t i = 0; i <= kMostElements; ++i) {
        zones.insert(zones.end(), {0x2A, 0});  // an empty zone
    }
    WorldDescriptionMessage read;
    EXPECT_FALSE(decode_message(zones, read));
    zones.resize(2 * kMostElements);
    EXPECT_TRUE(decode_message(zones, read));
}

}  // namespace
}  // namespace zoned::wire
