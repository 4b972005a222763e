#include "tests/lint/coverage/config_setting.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/io/tokenizer.h>
#include <google/protobuf/message.h>
#include <google/protobuf/text_format.h>

#include <algorithm>
#include <memory>

namespace zoned::lint {

namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::TextFormat;

/// Without it the parser would write to standard error.
class SilentErrors final : public google::protobuf::io::ErrorCollector {
    void AddError(int /*line*/, int /*column*/, const std::string& /*message*/) override {}
};

/// A message whose only field is `field` with this value; nothing where it is no value of it.
std::unique_ptr<Message> message_with(const FieldDescriptor* field, const std::string& value) {
    const Message* type = google::protobuf::MessageFactory::generated_factory()->GetPrototype(
        field->containing_type());
    std::unique_ptr<Message> message(type->New());
    const bool quoted = field->cpp_type() == FieldDescriptor::CPPTYPE_STRING;
    SilentErrors silent;
    TextFormat::Parser parser;
    parser.RecordErrorsTo(&silent);
    if (!parser.ParseFromString(field->name() + ": " + (quoted ? "'" + value + "'" : value),
                                message.get())) {
        return nullptr;
    }
    return message;
}

/// The text of one value; `index` -1: of a field that holds no list.
std::string value_text(const Message& message, const FieldDescriptor* field, int index) {
    std::string text;
    TextFormat::PrintFieldValueToString(message, field, index, &text);
    return text;
}

/// How the last field of a path is used in the message that holds it.
SettingUse use_in(const Message& message, const FieldDescriptor* field, const std::string& value) {
    const google::protobuf::Reflection& of = *message.GetReflection();
    const bool list = field->is_repeated();
    const bool written = list ? of.FieldSize(message, field) > 0 : of.HasField(message, field);
    if (value.empty()) {
        return written ? SettingUse::kWritten : SettingUse::kNone;
    }
    const std::unique_ptr<Message> asked = message_with(field, value);
    if (asked == nullptr) {
        return SettingUse::kNone;
    }
    const std::string text = value_text(*asked, field, list ? 0 : -1);
    if (!list) {
        return value_text(message, field, -1) != text ? SettingUse::kNone
               : written                              ? SettingUse::kWritten
                                                      : SettingUse::kDefault;
    }
    for (int i = 0; i < of.FieldSize(message, field); ++i) {
        if (value_text(message, field, i) == text) {
            return SettingUse::kWritten;
        }
    }
    return SettingUse::kNone;
}

SettingUse use_below(const Message& message, const ConfigSetting& setting, std::size_t depth) {
    const FieldDescriptor* field = setting.path[depth];
    if (depth + 1 == setting.path.size()) {
        return use_in(message, field, setting.value);
    }
    const google::protobuf::Reflection& of = *message.GetReflection();
    if (!field->is_repeated()) {
        return depth == 0 || of.HasField(message, field)
                   ? use_below(of.GetMessage(message, field), setting, depth + 1)
                   : SettingUse::kNone;
    }
    SettingUse most = SettingUse::kNone;
    for (int i = 0; i < of.FieldSize(message, field); ++i) {
        most =
            std::max(most, use_below(of.GetRepeatedMessage(message, field, i), setting, depth + 1));
    }
    return most;
}

}  // namespace

std::string read_setting(std::string_view text, ConfigSetting& setting) {
    setting = {};
    const std::size_t equals = text.find('=');
    std::string_view names = text.substr(0, equals);
    const Descriptor* message = proto::config::Config::descriptor();
    while (true) {
        const std::size_t dot = names.find('.');
        const std::string name(names.substr(0, dot));
        if (message == nullptr) {
            return "`" + setting.path.back()->name() + "` holds no `" + name + "`";
        }
        const FieldDescriptor* field = message->FindFieldByName(name);
        if (field == nullptr) {
            return "`" + message->name() + "` has no field `" + name + "`";
        }
        setting.path.push_back(field);
        message = field->message_type();
        if (dot == std::string_view::npos) {
            break;
        }
        names.remove_prefix(dot + 1);
    }
    if (equals == std::string_view::npos) {
        return {};
    }
    setting.value = text.substr(equals + 1);
    if (setting.value.empty() || message != nullptr ||
        message_with(setting.path.back(), setting.value) == nullptr) {
        return "`" + setting.value + "` is no value of `" + setting.path.back()->name() + "`";
    }
    return {};
}

SettingUse use_of(const proto::config::Config& world, const ConfigSetting& setting) {
    return use_below(world, setting, 0);
}

}  // namespace zoned::lint
