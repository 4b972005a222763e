// Peer messages: messages between the sandbox games of two zones, for effects across a border.
#pragma once

#include "server/rules/archive.h"
#include "server/zone/rules.h"

#include <optional>
#include <variant>

namespace zoned::rules {

/// To a character.
struct Hurt {
    EntityId by;
    std::uint32_t amount = 0;

    template <class Archive, class Self>
    static void fields(Archive& archive, Self& self) {
        archive(self.by);
        archive(self.amount);
    }
};

/// To a prop or a character: change of velocity, m/s.
struct Knock {
    Vec3 change = Vec3::Zero();

    template <class Archive, class Self>
    static void fields(Archive& archive, Self& self) {
        archive(self.change);
    }
};

/// To a prop: somebody of another zone reaches for it.
struct PickRequest {
    EntityId picker;

    template <class Archive, class Self>
    static void fields(Archive& archive, Self& self) {
        archive(self.picker);
    }
};

/// To the picker: the prop is hidden and reserved for it.
struct PickGrant {
    Item item;

    template <class Archive, class Self>
    static void fields(Archive& archive, Self& self) {
        Item::fields(archive, self.item);
    }
};

/// To the picker: somebody else was faster, or it may not be carried.
struct PickRefusal {
    EntityId item;

    template <class Archive, class Self>
    static void fields(Archive& archive, Self& self) {
        archive(self.item);
    }
};

/// To the prop: the picker has it (the entity can go) or could not take it (show it again).
struct PickDone {
    std::uint8_t taken = 0;

    template <class Archive, class Self>
    static void fields(Archive& archive, Self& self) {
        archive(self.taken);
    }
};

using PeerMessage = std::variant<Hurt, Knock, PickRequest, PickGrant, PickRefusal, PickDone>;

/// One byte for the alternative, then its fields.
zone::Bytes encode(const PeerMessage& message);
/// None when the bytes are not exactly one message with finite numbers.
std::optional<PeerMessage> decode(std::span<const std::uint8_t> payload);

}  // namespace zoned::rules
