// RandomMessage: fills any protobuf message with random fields, by its descriptor.
#pragma once

#include "shared/core/rng.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include <bit>
#include <string>

namespace zoned::test {

/// Numbers with all lengths on the wire: 0, small, large and negative ones.
inline std::uint64_t random_bits(core::Rng& rng) {
    const std::uint64_t bits = static_cast<std::uint64_t>(rng.next()) << 32U ^ rng.next();
    return rng.below(4) == 0 ? 0 : bits >> rng.below(64);
}

inline std::string random_text(core::Rng& rng) {
    std::string text(rng.below(3) == 0 ? 0 : rng.below(200), '\0');
    for (char& c : text) {
        c = static_cast<char>(rng.below(256));
    }
    return text;
}

void fill_randomly(google::protobuf::Message& message, core::Rng& rng);

/// Sets a singular field, or adds an element to a repeated one.
inline void fill_field(google::protobuf::Message& message,
                       const google::protobuf::FieldDescriptor& field,
                       core::Rng& rng) {
    using Field = google::protobuf::FieldDescriptor;
    const google::protobuf::Reflection& r = *message.GetReflection();
    const bool add = field.is_repeated();
    const std::uint64_t bits = random_bits(rng);
    switch (field.cpp_type()) {
        case Field::CPPTYPE_BOOL:
            add ? r.AddBool(&message, &field, (bits & 1U) != 0)
                : r.SetBool(&message, &field, (bits & 1U) != 0);
            break;
        case Field::CPPTYPE_INT32:
            add ? r.AddInt32(&message, &field, static_cast<std::int32_t>(bits))
                : r.SetInt32(&message, &field, static_cast<std::int32_t>(bits));
            break;
        case Field::CPPTYPE_UINT32:
            add ? r.AddUInt32(&message, &field, static_cast<std::uint32_t>(bits))
                : r.SetUInt32(&message, &field, static_cast<std::uint32_t>(bits));
            break;
        case Field::CPPTYPE_INT64:
            add ? r.AddInt64(&message, &field, static_cast<std::int64_t>(bits))
                : r.SetInt64(&message, &field, static_cast<std::int64_t>(bits));
            break;
        case Field::CPPTYPE_UINT64:
            add ? r.AddUInt64(&message, &field, bits) : r.SetUInt64(&message, &field, bits);
            break;
        case Field::CPPTYPE_FLOAT: {
            const auto number = std::bit_cast<float>(static_cast<std::uint32_t>(bits));
            add ? r.AddFloat(&message, &field, number) : r.SetFloat(&message, &field, number);
            break;
        }
        case Field::CPPTYPE_DOUBLE: {
            const auto number = std::bit_cast<double>(bits);
            add ? r.AddDouble(&message, &field, number) : r.SetDouble(&message, &field, number);
            break;
        }
        case Field::CPPTYPE_ENUM:
            add ? r.AddEnumValue(&message, &field, static_cast<int>(bits))
                : r.SetEnumValue(&message, &field, static_cast<int>(bits));
            break;
        case Field::CPPTYPE_STRING:
            add ? r.AddString(&message, &field, random_text(rng))
                : r.SetString(&message, &field, random_text(rng));
            break;
        case Field::CPPTYPE_MESSAGE:
            fill_randomly(
                add ? *r.AddMessage(&message, &field) : *r.MutableMessage(&message, &field), rng);
            break;
    }
}

inline void fill_randomly(google::protobuf::Message& message, core::Rng& rng) {
    const google::protobuf::Descriptor& descriptor = *message.GetDescriptor();
    const std::uint64_t chosen = rng.next();
    for (int i = 0; i < descriptor.field_count(); ++i) {
        const google::protobuf::FieldDescriptor& field = *descriptor.field(i);
        if (const auto* one_of = field.containing_oneof()) {
            // The last one that is set would win: all alternatives get their turn.
            if (chosen % static_cast<std::uint64_t>(one_of->field_count()) ==
                static_cast<std::uint64_t>(field.index_in_oneof())) {
                fill_field(message, field, rng);
            }
            continue;
        }
        const std::uint32_t most = field.is_repeated() ? 4 : 1;
        for (std::uint32_t n = rng.below(most + 1); n > 0; --n) {
            fill_field(message, field, rng);
        }
    }
}

}  // namespace zoned::test
