// MessageCodec: writes and reads plain structs as protobuf messages, by the field numbers that each
// struct names itself.
#pragma once

#include "shared/wire/session/message_bytes.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

namespace zoned::wire {

/// A message is a struct that shows its fields with their numbers, in ascending order:
///
///   struct EventAckMessage {
///       std::uint64_t through = 0;
///       static void fields(auto& m, auto& visit) { visit(1, m.through); }
///   };
///
/// Numbers and texts are left out where they are 0 or empty, as proto3 has it. A vector is a
/// repeated field, an optional a message that may be absent. A variant is a oneof of messages: the
/// number of an alternative is its place, and none of them is the first, std::monostate.
template <class Message>
void encode_message(const Message& message, std::vector<std::uint8_t>& out);

/// False for bytes that the protobuf library would refuse, or that hold more than kMostElements
/// messages in a field. Unknown fields are passed over.
template <class Message>
[[nodiscard]] bool decode_message(std::span<const std::uint8_t> bytes, Message& message);

/// Far beyond any world, and bounded: a message of two bytes takes a hundred in memory.
inline constexpr std::size_t kMostElements = std::size_t{1} << 20U;

/// Numbers that are short while they are small: whole numbers, truth values and enumerations.
template <class Number>
struct VarintCode {
    static constexpr WireType kType = WireType::kVarint;

    static void write(MessageWriter& out, Number number) {
        if constexpr (std::is_enum_v<Number>) {
            out.varint(static_cast<std::uint64_t>(static_cast<std::int64_t>(number)));
        } else {
            out.varint(static_cast<std::uint64_t>(number));
        }
    }

    static Number read(MessageReader& in) {
        const std::uint64_t value = in.varint();
        if constexpr (std::is_enum_v<Number>) {
            return static_cast<Number>(static_cast<std::underlying_type_t<Number>>(value));
        } else {
            return static_cast<Number>(value);
        }
    }
};

/// Numbers of four or eight bytes.
template <class Number>
struct FixedCode {
    static constexpr WireType kType = sizeof(Number) == 4 ? WireType::kFixed32 : WireType::kFixed64;

    static void write(MessageWriter& out, Number number) {
        if constexpr (sizeof(Number) == 4) {
            out.fixed32(std::bit_cast<std::uint32_t>(number));
        } else {
            out.fixed64(std::bit_cast<std::uint64_t>(number));
        }
    }

    static Number read(MessageReader& in) {
        if constexpr (sizeof(Number) == 4) {
            return std::bit_cast<Number>(in.fixed32());
        } else {
            return std::bit_cast<Number>(in.fixed64());
        }
    }
};

/// Whole numbers that are short while they are near 0.
struct ZigZagCode {
    static constexpr WireType kType = WireType::kVarint;

    static void write(MessageWriter& out, std::int32_t number) {
        const auto bits = static_cast<std::uint32_t>(number);
        out.varint(bits << 1U ^ (number < 0 ? UINT32_MAX : 0U));
    }

    static std::int32_t read(MessageReader& in) {
        const auto bits = static_cast<std::uint32_t>(in.varint());
        return static_cast<std::int32_t>(bits >> 1U ^ ((bits & 1U) != 0 ? UINT32_MAX : 0U));
    }
};

/// A field in a code that its type does not tell.
template <class Code, class Field>
struct CodedField {
    Field& field;
};

template <class Field>
CodedField<FixedCode<std::remove_const_t<Field>>, Field> fixed(Field& field) {
    return {field};
}

template <class Field>
CodedField<ZigZagCode, Field> zigzag(Field& field) {
    return {field};
}

template <class T>
concept MessageNumber = std::is_arithmetic_v<T> || std::is_enum_v<T>;

/// Left out on the wire. Judged by its bits: a negative zero is written.
template <MessageNumber Number>
bool is_default(Number value) {
    if constexpr (std::is_floating_point_v<Number>) {
        return value == Number{} && !std::signbit(value);
    } else {
        return value == Number{};
    }
}

template <MessageNumber Number>
using CodeOf =
    std::conditional_t<std::is_floating_point_v<Number>, FixedCode<Number>, VarintCode<Number>>;

/// Writes the fields of one message.
struct MessageEncoder {
    MessageWriter& out;

    template <class Message>
    void message(std::uint32_t number, const Message& nested) {
        out.tag(number, WireType::kDelimited);
        const std::size_t begun = out.begin();
        Message::fields(nested, *this);
        out.end(begun);
    }

    void message(std::uint32_t /*number*/, const std::monostate& /*nested*/) {}

    template <class Code, MessageNumber Number>
    void coded(std::uint32_t number, Number value) {
        if (!is_default(value)) {
            out.tag(number, Code::kType);
            Code::write(out, value);
        }
    }

    template <class Code, MessageNumber Number>
    void coded(std::uint32_t number, const std::vector<Number>& values) {
        if (!values.empty()) {
            out.tag(number, WireType::kDelimited);
            const std::size_t begun = out.begin();
            for (const Number value : values) {
                Code::write(out, value);
            }
            out.end(begun);
        }
    }

    template <class Code, class Field>
    void operator()(std::uint32_t number, const CodedField<Code, Field>& value) {
        coded<Code>(number, value.field);
    }

    template <MessageNumber Number>
    void operator()(std::uint32_t number, Number value) {
        coded<CodeOf<Number>>(number, value);
    }

    template <MessageNumber Number>
    void operator()(std::uint32_t number, const std::vector<Number>& values) {
        coded<CodeOf<Number>>(number, values);
    }

    void operator()(std::uint32_t number, const std::string& text) {
        if (!text.empty()) {
            out.tag(number, WireType::kDelimited);
            out.text(text);
        }
    }

    void operator()(std::uint32_t number, const std::vector<std::string>& texts) {
        for (const std::string& text : texts) {
            out.tag(number, WireType::kDelimited);
            out.text(text);
        }
    }

    template <class Message>
    void operator()(std::uint32_t number, const std::vector<Message>& messages) {
        for (const Message& one : messages) {
            message(number, one);
        }
    }

    template <class Message>
    void operator()(std::uint32_t number, const std::optional<Message>& maybe) {
        if (maybe) {
            message(number, *maybe);
        }
    }

    template <class... Messages>
    void one_of(const std::variant<Messages...>& field) {
        const auto number = static_cast<std::uint32_t>(field.index());
        std::visit([&](const auto& held) { message(number, held); }, field);
    }
};

/// Reads one field into whichever field of a message has its number. A field that comes twice is
/// merged as the protobuf library does; one in another wire type than its own is unknown.
struct MessageDecoder {
    MessageReader& in;
    MessageTag tag;
    int deepest = 0;
    bool taken = false;

    /// A message whose type only its fields() knows, so that all types share one loop.
    struct AnyMessage {
        void* message;
        void (*fields)(void* message, MessageDecoder& one);

        template <class Message>
        explicit AnyMessage(Message& of)
            : message(&of),
              fields([](void* it, MessageDecoder& one) {
                  Message::fields(*static_cast<Message*>(it), one);
              }) {}
    };

    /// Reads all fields of a message from its bytes.
    static bool decode(std::span<const std::uint8_t> bytes, AnyMessage message, int deepest);

    template <class Code, MessageNumber Number>
    void coded(Number& value) {
        if (tag.type == Code::kType) {
            taken = true;
            value = Code::read(in);
        }
    }

    template <class Code, MessageNumber Number>
    void coded(std::vector<Number>& values) {
        if (tag.type == Code::kType) {
            taken = true;
            values.push_back(Code::read(in));
        } else if (tag.type == WireType::kDelimited) {
            taken = true;
            MessageReader packed(in.delimited());
            while (!packed.done()) {
                values.push_back(Code::read(packed));
            }
            if (!packed.ok()) {
                in.fail();
            }
        }
    }

    template <class Code, class Field>
    void operator()(std::uint32_t number, const CodedField<Code, Field>& value) {
        if (number == tag.number) {
            coded<Code>(value.field);
        }
    }

    template <MessageNumber Number>
    void operator()(std::uint32_t number, Number& value) {
        if (number == tag.number) {
            coded<CodeOf<Number>>(value);
        }
    }

    template <MessageNumber Number>
    void operator()(std::uint32_t number, std::vector<Number>& values) {
        if (number == tag.number) {
            coded<CodeOf<Number>>(values);
        }
    }

    void operator()(std::uint32_t number, std::string& text) {
        if (delimited(number)) {
            taken = true;
            const auto bytes = in.delimited();
            text.assign(bytes.begin(), bytes.end());
        }
    }

    void operator()(std::uint32_t number, std::vector<std::string>& texts) {
        if (delimited(number) && has_room(texts.size())) {
            (*this)(number, texts.emplace_back());
        }
    }

    template <class Message>
    void operator()(std::uint32_t number, std::vector<Message>& messages) {
        if (delimited(number) && has_room(messages.size())) {
            nested(AnyMessage(messages.emplace_back()));
        }
    }

    template <class Message>
    void operator()(std::uint32_t number, std::optional<Message>& maybe) {
        if (delimited(number)) {
            nested(AnyMessage(maybe ? *maybe : maybe.emplace()));
        }
    }

    template <class... Messages>
    void one_of(std::variant<Messages...>& field) {
        alternatives(field, std::make_index_sequence<sizeof...(Messages) - 1>());
    }

  private:
    [[nodiscard]] bool delimited(std::uint32_t number) const {
        return number == tag.number && tag.type == WireType::kDelimited;
    }

    /// For one element more; fails where a field has too many.
    [[nodiscard]] bool has_room(std::size_t elements);
    void nested(AnyMessage message);

    template <class Variant, std::size_t... kPlace>
    void alternatives(Variant& field, std::index_sequence<kPlace...> /*places*/) {
        (alternative<kPlace + 1>(field), ...);
    }

    template <std::size_t kNumber, class Variant>
    void alternative(Variant& field) {
        if (delimited(kNumber)) {
            nested(AnyMessage(field.index() == kNumber ? std::get<kNumber>(field)
                                                       : field.template emplace<kNumber>()));
        }
    }
};

template <class Message>
void encode_message(const Message& message, std::vector<std::uint8_t>& out) {
    MessageWriter writer(out);
    MessageEncoder encoder{writer};
    Message::fields(message, encoder);
}

template <class Message>
bool decode_message(std::span<const std::uint8_t> bytes, Message& message) {
    message = {};
    return MessageDecoder::decode(
        bytes, MessageDecoder::AnyMessage(message), MessageReader::kDeepest);
}

}  // namespace zoned::wire
