#include "server/config/text/config_set.h"

#include "server/config/text/config_text.h"
#include "proto/config/config.pb.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/io/tokenizer.h>
#include <google/protobuf/text_format.h>

#include <cctype>
#include <optional>
#include <vector>

namespace zoned::config {

namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;
using google::protobuf::TextFormat;

/// One component of a path: name and what stands in brackets.
struct Component {
    std::string name;
    std::optional<std::string> index;
};

bool split_path(const std::string& path, std::vector<Component>& out) {
    std::size_t at = 0;
    while (at <= path.size()) {
        std::size_t end = at;
        int depth = 0;
        while (end < path.size() && (path[end] != '.' || depth > 0)) {
            depth += path[end] == '[' ? 1 : 0;
            depth -= path[end] == ']' ? 1 : 0;
            ++end;
        }
        Component component{path.substr(at, end - at), std::nullopt};
        const std::size_t open = component.name.find('[');
        if (open != std::string::npos) {
            if (component.name.back() != ']') {
                return false;
            }
            component.index = component.name.substr(open + 1, component.name.size() - open - 2);
            component.name.resize(open);
        }
        if (component.name.empty() || (component.index && component.index->empty())) {
            return false;
        }
        out.push_back(component);
        at = end + 1;
        if (end == path.size()) {
            break;
        }
    }
    return !out.empty();
}

/// Index of an element by number or by the value of its field `name`; -1 and a reason otherwise.
int find_element(const Message& message,
                 const FieldDescriptor& field,
                 const std::string& index,
                 std::string& reason) {
    const Reflection& reflection = *message.GetReflection();
    const int size = reflection.FieldSize(message, &field);
    const bool number =
        index.size() <= 9 && index.find_first_not_of("0123456789") == std::string::npos;
    if (number) {
        const int i = std::stoi(index);
        if (i <= size) {
            return i;
        }
        reason = field.name() + " has " + std::to_string(size) + " elements; [" + index +
                 "] is neither one of them nor the next, [" + std::to_string(size) + "]";
        return -1;
    }
    const FieldDescriptor* name =
        field.message_type() == nullptr ? nullptr : field.message_type()->FindFieldByName("name");
    for (int i = 0; name != nullptr && i < size; ++i) {
        const Message& element = reflection.GetRepeatedMessage(message, &field, i);
        if (element.GetReflection()->GetString(element, name) == index) {
            return i;
        }
    }
    reason = "no " + field.name() + " is named '" + index + "'";
    return -1;
}

class FirstError : public google::protobuf::io::ErrorCollector {
  public:
    void AddError(int /*line*/,
                  google::protobuf::io::ColumnNumber /*column*/,
                  const std::string& error) override {
        if (text.empty()) {
            text = error;
        }
    }

    std::string text;
};

/// Appends (lists) or sets one value; strings may come without quotes.
bool parse_value(const std::string& value,
                 const FieldDescriptor& field,
                 Message& message,
                 std::string& reason) {
    const bool bare = field.cpp_type() == FieldDescriptor::CPPTYPE_STRING &&
                      (value.size() < 2 || (value.front() != '"' && value.front() != '\''));
    if (bare) {
        if (field.is_repeated()) {
            message.GetReflection()->AddString(&message, &field, value);
        } else {
            message.GetReflection()->SetString(&message, &field, value);
        }
        return true;
    }
    FirstError errors;
    TextFormat::Parser parser;
    parser.RecordErrorsTo(&errors);
    parser.SetRecursionLimit(64);
    if (parser.ParseFieldValueFromString(value, &field, &message)) {
        return true;
    }
    reason = "'" + value + "' is not a value for it";
    if (field.enum_type() != nullptr) {
        reason += "; choose one of";
        for (int i = 0; i < field.enum_type()->value_count(); ++i) {
            reason += (i == 0 ? " " : ", ") + field.enum_type()->value(i)->name();
        }
    } else if (!errors.text.empty()) {
        reason += ": " + errors.text;
    }
    return false;
}

bool take_out(Message& message, const FieldDescriptor& field, int index, std::string& reason) {
    const Reflection& reflection = *message.GetReflection();
    const int size = reflection.FieldSize(message, &field);
    if (index == size) {
        reason = field.name() + " has " + std::to_string(size) + " elements: there is no [" +
                 std::to_string(index) + "] to take out";
        return false;
    }
    for (int i = index; i + 1 < size; ++i) {
        reflection.SwapElements(&message, &field, i, i + 1);
    }
    reflection.RemoveLast(&message, &field);
    return true;
}

/// Parses into a fresh message first, so that a bad value leaves the config as it was.
bool set_leaf(Message& message,
              const FieldDescriptor& field,
              const Component& component,
              std::string value,
              std::string& reason) {
    const Reflection& reflection = *message.GetReflection();
    if (!field.is_repeated()) {
        if (value.empty()) {
            reflection.ClearField(&message, &field);
            return true;
        }
        const std::unique_ptr<Message> fresh(message.New());
        if (!parse_value(value, field, *fresh, reason)) {
            return false;
        }
        reflection.ClearField(&message, &field);
        message.MergeFrom(*fresh);
        return true;
    }
    const std::unique_ptr<Message> fresh(message.New());
    if (!component.index) {
        std::size_t at = 0;
        const bool split = field.cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE;
        if (split && value.size() > 1 && value.front() == '[' && value.back() == ']') {
            value = value.substr(1, value.size() - 2);  // as a config writes a list
        }
        while (!value.empty() && at <= value.size()) {
            const std::size_t comma = split ? value.find(',', at) : std::string::npos;
            const std::size_t end = comma == std::string::npos ? value.size() : comma;
            if (!parse_value(value.substr(at, end - at), field, *fresh, reason)) {
                return false;
            }
            at = end + 1;
        }
        reflection.ClearField(&message, &field);
        message.MergeFrom(*fresh);
        return true;
    }
    const int i = find_element(message, field, *component.index, reason);
    const int size = reflection.FieldSize(message, &field);
    if (i >= 0 && value.empty()) {
        return take_out(message, field, i, reason);
    }
    if (i < 0 || !parse_value(value, field, *fresh, reason)) {
        return false;
    }
    // Appended at the end, then swapped into its place.
    message.MergeFrom(*fresh);
    if (i < size) {
        reflection.SwapElements(&message, &field, i, size);
        reflection.RemoveLast(&message, &field);
    }
    return true;
}

/// Steps into the message field named by `component`; null and a reason when that cannot be.
Message* step_into(Message& message,
                   const FieldDescriptor& field,
                   const Component& component,
                   std::string& here,
                   std::string& reason) {
    const Reflection& reflection = *message.GetReflection();
    if (field.cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE) {
        reason = field.name() + " is a single value and has nothing below it";
        return nullptr;
    }
    if (!field.is_repeated()) {
        if (component.index) {
            reason = field.name() + " is not a list: leave out [" + *component.index + "]";
            return nullptr;
        }
        here = join_path(here, field.name());
        return reflection.MutableMessage(&message, &field);
    }
    if (!component.index) {
        reason = field.name() + " is a list: say which element, such as " + field.name() + "[0]";
        return nullptr;
    }
    const int i = find_element(message, field, *component.index, reason);
    if (i < 0) {
        return nullptr;
    }
    here = join_path(here, field.name(), i);
    return i == reflection.FieldSize(message, &field)
               ? reflection.AddMessage(&message, &field)
               : reflection.MutableRepeatedMessage(&message, &field, i);
}

/// Applies to a copy; true when all went well. `here` becomes the path in canonical form.
bool assign(Message& config,
            const std::vector<Component>& components,
            const std::string& value,
            std::string& here,
            std::string& reason) {
    Message* message = &config;
    for (std::size_t c = 0; c < components.size(); ++c) {
        const Component& component = components[c];
        const FieldDescriptor* field = message->GetDescriptor()->FindFieldByName(component.name);
        if (field == nullptr) {
            reason = "there is no setting '" + component.name + "' in " +
                     (here.empty() ? std::string("the config") : here) +
                     advice_on(*message->GetDescriptor(), component.name);
            return false;
        }
        if (c + 1 == components.size()) {
            if (!field->is_repeated() && component.index) {
                reason = field->name() + " is not a list: leave out [" + *component.index + "]";
                return false;
            }
            int index = -1;
            if (field->is_repeated() && component.index) {
                index = find_element(*message, *field, *component.index, reason);
                if (index < 0) {
                    return false;
                }
            }
            // Where an element is taken out, those after it stand elsewhere in the text.
            here = join_path(here, field->name(), value.empty() ? -1 : index);
            return set_leaf(*message, *field, component, value, reason);
        }
        message = step_into(*message, *field, component, here, reason);
        if (message == nullptr) {
            return false;
        }
    }
    return false;
}

}  // namespace

void apply_set(const std::string& assignment,
               proto::config::Config& config,
               Diagnostics& diagnostics) {
    // The first '=' outside brackets: names in brackets may hold one.
    std::size_t equals = 0;
    int depth = 0;
    while (equals < assignment.size() && (assignment[equals] != '=' || depth > 0)) {
        depth += assignment[equals] == '[' ? 1 : 0;
        depth -= assignment[equals] == ']' ? 1 : 0;
        ++equals;
    }
    const std::string path = assignment.substr(0, equals);
    if (equals == assignment.size()) {
        diagnostics.add_at(0, 0, path, "--set needs path=value, got '" + assignment + "'");
        return;
    }
    std::vector<Component> components;
    if (!split_path(path, components)) {
        diagnostics.add_at(
            0, 0, path, "--set: '" + path + "' is not a path such as zones.zone[1].name");
        return;
    }
    proto::config::Config changed = config;
    std::string here;
    std::string reason;
    if (!assign(changed, components, assignment.substr(equals + 1), here, reason)) {
        diagnostics.add_at(0, 0, path, "--set: " + reason);
        return;
    }
    config.Swap(&changed);
    diagnostics.forget_place(here);
}

}  // namespace zoned::config
