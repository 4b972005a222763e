#include "server/config/text/config_set.h"
#include "proto/range.pb.h"

#include <google/protobuf/descriptor.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace zoned::config {

namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;

std::string number_text(double value) {
    char buffer[40];
    std::snprintf(buffer, sizeof(buffer), "%.10g", value);
    return buffer;
}

/// The number in the field, as a double (64-bit integers lose their last bits: ranges do not
/// depend on them).
double number_of(const Message& message, const FieldDescriptor& field, int index) {
    const Reflection& r = *message.GetReflection();
    const bool repeated = field.is_repeated();
    switch (field.cpp_type()) {
        case FieldDescriptor::CPPTYPE_DOUBLE:
            return repeated ? r.GetRepeatedDouble(message, &field, index)
                            : r.GetDouble(message, &field);
        case FieldDescriptor::CPPTYPE_FLOAT:
            return repeated ? r.GetRepeatedFloat(message, &field, index)
                            : r.GetFloat(message, &field);
        case FieldDescriptor::CPPTYPE_INT32:
            return repeated ? r.GetRepeatedInt32(message, &field, index)
                            : r.GetInt32(message, &field);
        case FieldDescriptor::CPPTYPE_UINT32:
            return repeated ? r.GetRepeatedUInt32(message, &field, index)
                            : r.GetUInt32(message, &field);
        case FieldDescriptor::CPPTYPE_INT64:
            return static_cast<double>(repeated ? r.GetRepeatedInt64(message, &field, index)
                                                : r.GetInt64(message, &field));
        case FieldDescriptor::CPPTYPE_UINT64:
            return static_cast<double>(repeated ? r.GetRepeatedUInt64(message, &field, index)
                                                : r.GetUInt64(message, &field));
        default:
            return 0.0;
    }
}

/// Replaces a number.
void set_number(Message& message, const FieldDescriptor& field, int index, double value) {
    const Reflection& r = *message.GetReflection();
    const bool repeated = field.is_repeated();
    switch (field.cpp_type()) {
        case FieldDescriptor::CPPTYPE_DOUBLE:
            repeated ? r.SetRepeatedDouble(&message, &field, index, value)
                     : r.SetDouble(&message, &field, value);
            break;
        case FieldDescriptor::CPPTYPE_UINT32: {
            const auto number = static_cast<std::uint32_t>(value);
            repeated ? r.SetRepeatedUInt32(&message, &field, index, number)
                     : r.SetUInt32(&message, &field, number);
            break;
        }
        case FieldDescriptor::CPPTYPE_UINT64: {
            const auto number = static_cast<std::uint64_t>(value);
            repeated ? r.SetRepeatedUInt64(&message, &field, index, number)
                     : r.SetUInt64(&message, &field, number);
            break;
        }
        default:
            break;  // the schema uses no other numbers
    }
}

/// Replacement for a value out of range: the default, or else `nearest`. With it the checks of
/// relations find no mistakes that are only its consequence.
double substitute(const FieldDescriptor& field, double nearest) {
    if (!field.has_default_value()) {
        return nearest;
    }
    switch (field.cpp_type()) {
        case FieldDescriptor::CPPTYPE_DOUBLE:
            return field.default_value_double();
        case FieldDescriptor::CPPTYPE_UINT32:
            return field.default_value_uint32();
        case FieldDescriptor::CPPTYPE_UINT64:
            return static_cast<double>(field.default_value_uint64());
        default:
            return nearest;
    }
}

class RangeCheck {
  public:
    RangeCheck(bool complete, Diagnostics& diagnostics)
        : complete_(complete),
          diagnostics_(diagnostics) {}

    void check_message(Message& message, const std::string& path) {
        const Reflection& reflection = *message.GetReflection();
        for (int f = 0; f < message.GetDescriptor()->field_count(); ++f) {
            const FieldDescriptor& field = *message.GetDescriptor()->field(f);
            if (field.is_repeated()) {
                check_list(message, field, path);
            } else if (!reflection.HasField(message, &field)) {
                continue;
            } else if (field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
                check_message(*reflection.MutableMessage(&message, &field),
                              join_path(path, field.name()));
            } else {
                check_value(message, field, -1, join_path(path, field.name()));
            }
        }
    }

  private:
    void check_value(Message& message,
                     const FieldDescriptor& field,
                     int index,
                     const std::string& path) {
        if (!field.options().HasExtension(proto::range)) {
            return;
        }
        const proto::FieldRange& range = field.options().GetExtension(proto::range);
        const std::string wish = interval_text(range);
        if (field.cpp_type() == FieldDescriptor::CPPTYPE_STRING) {
            const Reflection& r = *message.GetReflection();
            const std::string value = index < 0 ? r.GetString(message, &field)
                                                : r.GetRepeatedString(message, &field, index);
            const auto length = static_cast<double>(value.size());
            if (length < range.min() || length > range.max()) {
                diagnostics_.add(
                    path, "has " + number_text(length) + " bytes; its length must lie in " + wish);
            }
            return;
        }
        const double value = number_of(message, field, index);
        if (!std::isfinite(value)) {
            diagnostics_.add(path, "is not a finite number; it must lie in " + wish);
            set_number(message, field, index, substitute(field, range.min()));
        } else if (value < range.min() || value > range.max()) {
            diagnostics_.add(path, number_text(value) + " is out of range; it must lie in " + wish);
            set_number(message,
                       field,
                       index,
                       substitute(field, std::clamp(value, range.min(), range.max())));
        }
    }

    void check_length(Message& message, const FieldDescriptor& field, const std::string& path) {
        const Reflection& reflection = *message.GetReflection();
        const int size = reflection.FieldSize(message, &field);
        const proto::FieldRange& range = field.options().GetExtension(proto::range);
        if (size > range.max() || (size < range.min() && complete_)) {
            diagnostics_.add(
                size == 0 ? join_path(path, field.name()) : join_path(path, field.name(), size - 1),
                "there are " + std::to_string(size) + " of " + field.name() +
                    "; their number must lie in " + interval_text(range));
        }
        for (int i = size; i > range.max(); --i) {
            reflection.RemoveLast(&message, &field);
        }
    }

    void check_list(Message& message, const FieldDescriptor& field, const std::string& path) {
        const Reflection& reflection = *message.GetReflection();
        const bool of_messages = field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE;
        if (of_messages && field.options().HasExtension(proto::range)) {
            check_length(message, field, path);
        }
        const int size = reflection.FieldSize(message, &field);
        for (int i = 0; i < size; ++i) {
            const std::string element = join_path(path, field.name(), i);
            if (of_messages) {
                check_message(*reflection.MutableRepeatedMessage(&message, &field, i), element);
            } else {
                check_value(message, field, i, element);
            }
        }
    }

    static std::string interval_text(const proto::FieldRange& range) {
        return "[" + number_text(range.min()) + ".." + number_text(range.max()) + "]";
    }

    bool complete_;
    Diagnostics& diagnostics_;
};

}  // namespace

void check_ranges(google::protobuf::Message& config, bool complete, Diagnostics& diagnostics) {
    RangeCheck(complete, diagnostics).check_message(config, "");
}

}  // namespace zoned::config
