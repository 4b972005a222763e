#include "server/config/expand/reload_plan.h"

#include "server/config/expand/live_paths.h"
#include "server/config/expand/load_settings.h"
#include "server/config/expand/reload_diff.h"
#include "server/config/text/diagnostics.h"
#include "proto/config/config.pb.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/text_format.h>
#include <google/protobuf/util/message_differencer.h>

#include <algorithm>
#include <utility>

namespace zoned::config {

namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;
using google::protobuf::TextFormat;
using google::protobuf::util::MessageDifferencer;
using proto::config::Config;

constexpr std::size_t kMostChanges = 500;
constexpr std::size_t kMostValueBytes = 80;

std::string shortened(std::string text) {
    if (text.size() > kMostValueBytes) {
        text.replace(kMostValueBytes, std::string::npos, "...");
    }
    return text;
}

/// A message is long; whether it is there says enough.
std::string value_text(const Message& message, const FieldDescriptor& field, int index) {
    if (field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
        const bool there =
            field.is_repeated() || message.GetReflection()->HasField(message, &field);
        return there ? "set" : "not set";
    }
    std::string text;
    TextFormat::PrintFieldValueToString(message, &field, index, &text);
    return text;
}

std::string count_text(int count) {
    return std::to_string(count) + (count == 1 ? " entry" : " entries");
}

/// Collects what differs, at its deepest.
class DiffWalk {
  public:
    explicit DiffWalk(std::vector<SettingChange>& out) : out_(out) {}

    void compare(const Message& a, const Message& b, const std::string& path) {
        for (int f = 0; f < a.GetDescriptor()->field_count(); ++f) {
            const FieldDescriptor& field = *a.GetDescriptor()->field(f);
            MessageDifferencer differencer;
            if (out_.size() < kMostChanges &&
                !differencer.CompareWithFields(a, b, {&field}, {&field})) {
                compare_field(a, b, field, path);
            }
        }
    }

  private:
    void compare_field(const Message& a,
                       const Message& b,
                       const FieldDescriptor& field,
                       const std::string& path) {
        const Reflection& r = *a.GetReflection();
        const bool message = field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE;
        if (field.is_repeated()) {
            compare_entries(a, b, field, path);
        } else if (message) {
            // A block that is not there has its defaults.
            compare(
                r.GetMessage(a, &field), r.GetMessage(b, &field), join_path(path, field.name()));
        } else if (value_text(a, field, -1) != value_text(b, field, -1)) {
            add(join_path(path, field.name()), value_text(a, field, -1), value_text(b, field, -1));
        }
    }

    void compare_entries(const Message& a,
                         const Message& b,
                         const FieldDescriptor& field,
                         const std::string& path) {
        const Reflection& r = *a.GetReflection();
        const int count = r.FieldSize(a, &field);
        if (count != r.FieldSize(b, &field)) {
            add(join_path(path, field.name()),
                count_text(count),
                count_text(r.FieldSize(b, &field)));
            return;
        }
        for (int i = 0; i < count; ++i) {
            const std::string here = join_path(path, field.name(), i);
            if (field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
                compare(
                    r.GetRepeatedMessage(a, &field, i), r.GetRepeatedMessage(b, &field, i), here);
            } else if (value_text(a, field, i) != value_text(b, field, i)) {
                add(here, value_text(a, field, i), value_text(b, field, i));
            }
        }
    }

    void add(const std::string& path, std::string before, std::string after) {
        out_.push_back({path,
                        shortened(std::move(before)),
                        shortened(std::move(after)),
                        is_live_setting(path),
                        std::string()});
    }

    std::vector<SettingChange>& out_;
};

/// "type[3].brain.x" -> "type"; `rest` is what follows the index and the dot.
std::string_view first_of(std::string_view path, std::string_view& rest) {
    const std::size_t end = std::min(path.find_first_of("[."), path.size());
    const std::size_t dot = path.find('.');
    rest = dot == std::string_view::npos ? std::string_view() : path.substr(dot + 1);
    return path.substr(0, end);
}

template <class List>
bool holds(const List& list, std::string_view word) {
    return std::find(list.begin(), list.end(), word) != list.end();
}

bool is_brain_setting(std::string_view path) {
    std::string_view rest;
    const std::string_view first = first_of(path, rest);
    if (holds(kBrainFields, first)) {
        return true;
    }
    std::string_view unused;
    return first == "type" && holds(kTypeBrainFields, first_of(rest, unused));
}

bool same_types(const Config& a, const Config& b) {
    return std::equal(a.type().begin(),
                      a.type().end(),
                      b.type().begin(),
                      b.type().end(),
                      [](const auto& x, const auto& y) { return x.name() == y.name(); });
}

void take_brains(const Config& from, Config& to) {
    for (const std::string_view field : kBrainFields) {
        take_setting(field, &from, to);
    }
    for (int t = 0; t < to.type_size(); ++t) {
        for (const std::string_view field : kTypeBrainFields) {
            take_setting(field, &from.type(t), *to.mutable_type(t));
        }
    }
}

bool read_back(const std::string& text, Config& out) {
    TextFormat::Parser parser;
    parser.SetRecursionLimit(64);
    return parser.ParseFromString(text, &out);
}

/// The number of sessions that the sockets were made for is set at the start.
void hold_back_larger(const Settings& running, const Settings& fresh, ReloadPlan& plan) {
    if (fresh.server.network.max_clients <= running.server.started_max_clients) {
        return;
    }
    for (SettingChange& change : plan.changes) {
        if (change.path == "network.max_clients") {
            change.live = false;
            change.note = "a running server has sockets for at most " +
                          std::to_string(running.server.started_max_clients) +
                          " clients, as it was started with";
        }
    }
}

bool any_live(const ReloadPlan& plan, bool brains) {
    return std::any_of(plan.changes.begin(), plan.changes.end(), [brains](const auto& change) {
        return change.live && is_brain_setting(change.path) == brains;
    });
}

}  // namespace

void take_setting(std::string_view path, const Message* from, Message& to) {
    const std::size_t dot = path.find('.');
    const FieldDescriptor* field =
        to.GetDescriptor()->FindFieldByName(std::string(path.substr(0, dot)));
    const Reflection& r = *to.GetReflection();
    if (dot != std::string_view::npos) {
        if (from != nullptr || r.HasField(to, field)) {
            take_setting(path.substr(dot + 1),
                         from != nullptr ? &r.GetMessage(*from, field) : nullptr,
                         *r.MutableMessage(&to, field));
        }
        if (from == nullptr && r.GetMessage(to, field).ByteSizeLong() == 0) {
            r.ClearField(&to, field);  // a block without a setting is none
        }
        return;
    }
    r.ClearField(&to, field);
    if (from != nullptr) {
        const std::unique_ptr<Message> copy(from->New());
        copy->CopyFrom(*from);
        r.SwapFields(copy.get(), &to, {field});
    }
}

std::vector<std::string> live_settings() {
    return {kLivePaths.begin(), kLivePaths.end()};
}

bool is_live_setting(std::string_view path) {
    const bool server =
        std::any_of(kLivePaths.begin(), kLivePaths.end(), [path](std::string_view live) {
            return path.starts_with(live) && (path.size() == live.size() ||
                                              path[live.size()] == '[' || path[live.size()] == '.');
        });
    return server || is_brain_setting(path);
}

core::Result<ReloadPlan> plan_reload(const Settings& running, const Settings& fresh) {
    using Planned = core::Result<ReloadPlan>;
    ReloadPlan plan;
    Config a;
    Config b;
    if (!read_back(running.text, a) || !read_back(fresh.text, b)) {
        return Planned::failure("the canonical text of a config cannot be read back");
    }
    DiffWalk(plan.changes).compare(a, b, "");
    hold_back_larger(running, fresh, plan);
    const bool types = same_types(a, b);
    for (SettingChange& change : plan.changes) {
        if (!types && is_brain_setting(change.path)) {
            change.live = false;
            change.note = "the list of types changed too";
        }
    }
    const bool brains = any_live(plan, true);
    if (!brains && !any_live(plan, false)) {
        return plan;
    }
    for (const std::string_view path : kLivePaths) {
        const bool held = std::any_of(
            plan.changes.begin(), plan.changes.end(), [path](const SettingChange& change) {
                return change.path == path && !change.live;
            });
        if (!held) {
            take_setting(path, &b, a);
        }
    }
    if (brains) {
        take_brains(b, a);
    }
    std::string text;
    TextFormat::PrintToString(a, &text);
    auto merged = std::make_shared<Settings>();
    std::vector<ConfigError> errors;
    if (!parse_settings(text, {}, *merged, errors)) {
        return Planned::failure(
            "without the settings that take a restart the rest is no good "
            "config: " +
            format_errors("reload", errors));
    }
    merged->server.started_max_clients = running.server.started_max_clients;
    if (brains) {
        auto agents = new_brains(running, *merged);
        if (!agents.ok()) {
            return Planned::failure(agents.error());
        }
        plan.brains = *agents;
    }
    plan.merged = std::move(merged);
    return plan;
}

}  // namespace zoned::config
