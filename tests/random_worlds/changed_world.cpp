#include "tests/random_worlds/changed_world.h"

#include "server/app/runtime/live_settings.h"
#include "server/config/expand/load_settings.h"
#include "server/config/text/config_set.h"
#include "server/config/text/read_text.h"
#include "proto/range.pb.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/text_format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <memory>
#include <set>
#include <stdexcept>
#include <utility>

namespace zoned::random_worlds {

namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;
using proto::config::Config;

/// Elements of a list that a change may fall on: no list drowns the rest.
constexpr int kMostOfAList = 3;
/// Trials to find the next change that the checks accept.
constexpr int kTrials = 12;
/// Trials to find all changes that are read anew: most that are drawn are not of agents.
constexpr int kReloadTrials = 150;
/// A drawn number of entities is at most so many times the present one, or this.
constexpr double kMostCountFactor = 4.0;
constexpr double kLeastMostCount = 60.0;
/// Parts that come along with one that is taken from another world, for their names.
constexpr std::size_t kMostGuests = 12;

bool is_process_setting(const std::string& name) {
    static const std::set<std::string> kNames = {"testing",
                                                 "network",
                                                 "session",
                                                 "recording",
                                                 "store",
                                                 "recovery",
                                                 "cluster",
                                                 "arrival",
                                                 "portal",
                                                 "run",
                                                 "compute",
                                                 "log",
                                                 "audit"};
    return kNames.contains(name);
}

std::string text_of(const Message& message) {
    google::protobuf::TextFormat::Printer printer;
    printer.SetSingleLineMode(true);
    std::string text;
    printer.PrintToString(message, &text);
    return "{ " + text + "}";
}

/// A message of the config, and the path to it.
struct ConfigPlace {
    std::string path;
    const Message* message;
};

std::string name_of(const Message& element) {
    const FieldDescriptor* name = element.GetDescriptor()->FindFieldByName("name");
    const bool is_text = name != nullptr && !name->is_repeated() &&
                         name->cpp_type() == FieldDescriptor::CPPTYPE_STRING;
    return is_text ? element.GetReflection()->GetString(element, name) : std::string();
}

std::string element_path(const std::string& list, const Message& element, int index) {
    const std::string name = name_of(element);
    return list + "[" + (name.empty() ? std::to_string(index) : name) + "]";
}

void collect(const Message& message,
             const std::string& path,
             core::Rng& rng,
             std::vector<ConfigPlace>& out) {
    out.push_back({path, &message});
    const Reflection& r = *message.GetReflection();
    std::vector<const FieldDescriptor*> fields;
    r.ListFields(message, &fields);
    for (const FieldDescriptor* field : fields) {
        if (field->cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE ||
            (path.empty() && is_process_setting(field->name()))) {
            continue;
        }
        const std::string here = config::join_path(path, field->name());
        if (!field->is_repeated()) {
            collect(r.GetMessage(message, field), here, rng, out);
            continue;
        }
        const int size = r.FieldSize(message, field);
        for (int k = 0; k < std::min(size, kMostOfAList); ++k) {
            const int i = size <= kMostOfAList
                              ? k
                              : static_cast<int>(rng.below(static_cast<std::uint32_t>(size)));
            const Message& element = r.GetRepeatedMessage(message, field, i);
            collect(element, element_path(here, element, i), rng, out);
        }
    }
}

double present_number(const Message& message, const FieldDescriptor& field) {
    const Reflection& r = *message.GetReflection();
    switch (field.cpp_type()) {
        case FieldDescriptor::CPPTYPE_DOUBLE:
            return r.GetDouble(message, &field);
        case FieldDescriptor::CPPTYPE_UINT32:
            return r.GetUInt32(message, &field);
        case FieldDescriptor::CPPTYPE_UINT64:
            return static_cast<double>(r.GetUInt64(message, &field));
        default:
            return 0.0;
    }
}

/// Most often something like the present number; now and then one from anywhere, or an end.
double draw_number(core::Rng& rng, double now, double least, double most) {
    double number = 0.0;
    switch (rng.below(8)) {
        case 0:
            number = least;
            break;
        case 1:
            number = most;
            break;
        case 2:
            number = least + (most - least) * static_cast<double>(rng.unit());
            break;
        case 3: {
            const double low = std::log(std::max(least, 1e-3 * std::max(1.0, std::abs(now))));
            const double high = std::log(std::max(most, 1e-2));
            number = std::exp(low + (high - low) * static_cast<double>(rng.unit()));
            break;
        }
        default:
            number = now == 0.0 ? 2.0 * static_cast<double>(rng.unit()) - 1.0
                                : now * std::exp2(4.0 * static_cast<double>(rng.unit()) - 2.0);
    }
    return std::clamp(number, least, most);
}

std::string number_text(const Message& message, const FieldDescriptor& field, core::Rng& rng) {
    const proto::FieldRange& range = field.options().GetExtension(proto::range);
    const double now = present_number(message, field);
    double most = range.max();
    if (field.name() == "count" || field.name() == "columns" || field.name() == "rows") {
        most = std::min(most, std::max(kMostCountFactor * now, kLeastMostCount));
    }
    double number = draw_number(rng, now, range.min(), most);
    char text[40];
    if (field.cpp_type() != FieldDescriptor::CPPTYPE_DOUBLE) {
        number = std::min(std::round(number), 1e9);  // larger ones are seeds: all alike
        std::snprintf(text, sizeof(text), "%.0f", number);
    } else {
        std::snprintf(text, sizeof(text), "%.5g", number);
    }
    return text;
}

/// All names and references in a message.
void collect_strings(const Message& message, std::set<std::string>& out) {
    const Reflection& r = *message.GetReflection();
    std::vector<const FieldDescriptor*> fields;
    r.ListFields(message, &fields);
    for (const FieldDescriptor* field : fields) {
        const int size = field->is_repeated() ? r.FieldSize(message, field) : 1;
        for (int i = 0; i < size; ++i) {
            if (field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
                collect_strings(field->is_repeated() ? r.GetRepeatedMessage(message, field, i)
                                                     : r.GetMessage(message, field),
                                out);
            } else if (field->cpp_type() == FieldDescriptor::CPPTYPE_STRING) {
                out.insert(field->is_repeated() ? r.GetRepeatedString(message, field, i)
                                                : r.GetString(message, field));
            }
        }
    }
}

std::string draw_scalar(const Config& config,
                        const Message& message,
                        const FieldDescriptor& field,
                        core::Rng& rng) {
    switch (field.cpp_type()) {
        case FieldDescriptor::CPPTYPE_BOOL:
            return message.GetReflection()->GetBool(message, &field) ? "false" : "true";
        case FieldDescriptor::CPPTYPE_ENUM: {
            const auto count = static_cast<std::uint32_t>(field.enum_type()->value_count());
            return field.enum_type()->value(static_cast<int>(rng.below(count)))->name();
        }
        case FieldDescriptor::CPPTYPE_STRING: {
            std::set<std::string> all;
            collect_strings(config, all);
            const auto at = rng.below(static_cast<std::uint32_t>(all.size()));
            return *std::next(all.begin(), at);
        }
        default:
            return number_text(message, field, rng);
    }
}

/// A random element of a list, with one of its settings changed, appended to it.
std::string draw_copy(const Config& config,
                      const ConfigPlace& place,
                      const FieldDescriptor& list,
                      core::Rng& rng) {
    const Reflection& r = *place.message->GetReflection();
    const int size = r.FieldSize(*place.message, &list);
    const Message& original = r.GetRepeatedMessage(
        *place.message, &list, static_cast<int>(rng.below(static_cast<std::uint32_t>(size))));
    const std::unique_ptr<Message> copy(original.New());
    copy->CopyFrom(original);
    if (const std::string name = name_of(*copy); !name.empty()) {
        copy->GetReflection()->SetString(copy.get(),
                                         copy->GetDescriptor()->FindFieldByName("name"),
                                         name + std::to_string(size));
    }
    std::vector<const FieldDescriptor*> fields;
    copy->GetReflection()->ListFields(*copy, &fields);
    std::erase_if(fields, [](const FieldDescriptor* field) {
        return field->is_repeated() || field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE ||
               field->name() == "name";
    });
    std::string text = text_of(*copy);
    if (!fields.empty()) {
        const auto& field = *fields[rng.below(static_cast<std::uint32_t>(fields.size()))];
        copy->GetReflection()->ClearField(copy.get(), &field);
        const std::string value = draw_scalar(config, original, field, rng);
        const bool quoted = field.cpp_type() == FieldDescriptor::CPPTYPE_STRING;
        text = text_of(*copy);
        text.insert(text.size() - 1,
                    field.name() + ": " + (quoted ? "\"" + value + "\"" : value) + " ");
    }
    return config::join_path(place.path, list.name()) + "[" + std::to_string(size) + "]=" + text;
}

bool apply_sets(const std::vector<std::string>& sets, Config& config) {
    for (const std::string& one : sets) {
        config::Diagnostics diagnostics;
        config::apply_set(one, config, diagnostics);
        if (!diagnostics.empty()) {
            return false;
        }
    }
    return true;
}

}  // namespace

std::string command_of(const ChangedWorld& world) {
    std::string command = "zoned serve " + world.file;
    for (const std::string& one : world.sets) {
        command += " \\\n    --set '" + one + "'";
    }
    if (!world.reload.empty()) {
        command += "\n  reads anew:";
    }
    for (const std::string& one : world.reload) {
        command += "\n    --reload '" + one + "'";
    }
    return command;
}

bool is_accepted(const ChangedWorld& world) {
    config::Settings settings;
    std::vector<config::ConfigError> errors;
    return config::load_settings(world.file, world.sets, settings, errors);
}

core::Result<mailbox::NewBrains> brains_of_reload(const ChangedWorld& world) {
    using Brains = core::Result<mailbox::NewBrains>;
    if (world.reload.empty()) {
        return Brains::failure("nothing is read anew");
    }
    std::vector<std::string> sets = world.sets;
    sets.insert(sets.end(), world.reload.begin(), world.reload.end());
    config::Settings running;
    std::vector<config::ConfigError> errors;
    if (!config::load_settings(world.file, world.sets, running, errors)) {
        return Brains::failure(config::format_errors(world.file, errors));
    }
    const auto prepared = app::prepare_reload(world.file, sets, running);
    if (!prepared.ok()) {
        return Brains::failure(prepared.error());
    }
    const config::ReloadPlan& plan = prepared->plan;
    if (plan.brains == nullptr) {
        return Brains::failure("no agents change: " + app::text_of(plan.changes));
    }
    return mailbox::NewBrains{std::make_shared<const std::string>(plan.merged->text), plan.brains};
}

WorldChanger::WorldChanger(std::vector<std::string> files) {
    for (std::string& file : files) {
        ShippedWorld& world = worlds_.emplace_back();
        std::string text;
        const std::string unread = config::read_text(file, text);
        if (!unread.empty() ||
            !google::protobuf::TextFormat::ParseFromString(text, &world.config)) {
            throw std::runtime_error(unread.empty() ? file + " is no config" : unread);
        }
        world.file = std::move(file);
    }
}

ChangedWorld WorldChanger::draw(core::Rng& rng, int most_changes) const {
    const auto& shipped = worlds_[rng.below(static_cast<std::uint32_t>(worlds_.size()))];
    ChangedWorld world{shipped.file, {}};
    Config config = shipped.config;
    const auto extra = static_cast<std::uint32_t>(std::max(1, most_changes));
    const int wanted = most_changes == 0 ? 0 : 1 + static_cast<int>(rng.below(extra));
    for (int made = 0, trial = 0; made < wanted && trial < kTrials * wanted; ++trial) {
        const auto sets = rng.below(4) == 0 ? draw_guest(config, rng) : draw_change(config, rng);
        Config changed = config;
        if (sets.empty() || !apply_sets(sets, changed)) {
            continue;
        }
        ChangedWorld next = world;
        next.sets.insert(next.sets.end(), sets.begin(), sets.end());
        std::fprintf(stderr, "%s\n", command_of(next).c_str());  // should the checks crash
        if (is_accepted(next)) {
            world = std::move(next);
            config = std::move(changed);
            ++made;
        }
    }
    return world;
}

void WorldChanger::draw_reload(core::Rng& rng, int most_changes, ChangedWorld& world) const {
    const auto shipped = std::find_if(worlds_.begin(), worlds_.end(), [&](const ShippedWorld& one) {
        return one.file == world.file;
    });
    Config config = shipped->config;
    if (!apply_sets(world.sets, config)) {
        return;
    }
    const int wanted =
        1 + static_cast<int>(rng.below(static_cast<std::uint32_t>(std::max(1, most_changes))));
    for (int made = 0, trial = 0; made < wanted && trial < kReloadTrials; ++trial) {
        const auto sets = draw_change(config, rng);
        Config changed = config;
        if (sets.empty() ||
            !config::is_live_setting(sets.front().substr(0, sets.front().find('='))) ||
            !apply_sets(sets, changed)) {
            continue;
        }
        ChangedWorld next = world;
        next.reload.insert(next.reload.end(), sets.begin(), sets.end());
        if (brains_of_reload(next).ok()) {
            world = std::move(next);
            config = std::move(changed);
            ++made;
        }
    }
}

std::vector<std::string> WorldChanger::draw_change(const Config& config, core::Rng& rng) const {
    std::vector<ConfigPlace> places;
    collect(config, "", rng, places);
    const ConfigPlace& place = places[rng.below(static_cast<std::uint32_t>(places.size()))];
    const auto& type = *place.message->GetDescriptor();
    if (type.field_count() == 0) {
        return {};
    }
    const auto& field =
        *type.field(static_cast<int>(rng.below(static_cast<std::uint32_t>(type.field_count()))));
    if ((place.path.empty() && is_process_setting(field.name())) || field.name() == "name") {
        return {};
    }
    const std::string path = config::join_path(place.path, field.name());
    const Reflection& r = *place.message->GetReflection();
    if (field.is_repeated()) {
        const bool can = field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE &&
                         r.FieldSize(*place.message, &field) > 0;
        if (!can) {
            return {};
        }
        if (rng.below(3) == 0) {
            const int size = r.FieldSize(*place.message, &field);
            const int at = static_cast<int>(rng.below(static_cast<std::uint32_t>(size)));
            const Message& element = r.GetRepeatedMessage(*place.message, &field, at);
            return {element_path(path, element, at) + "="};
        }
        return {rng.below(8) == 0 ? path + "=" : draw_copy(config, place, field, rng)};
    }
    if (r.HasField(*place.message, &field) && rng.below(6) == 0) {
        return {path + "="};
    }
    if (field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
        return {path + "={}"};
    }
    return {path + "=" + draw_scalar(config, *place.message, field, rng)};
}

std::vector<std::string> WorldChanger::draw_guest(const Config& config, core::Rng& rng) const {
    const Config& donor = worlds_[rng.below(static_cast<std::uint32_t>(worlds_.size()))].config;
    const Reflection& r = *donor.GetReflection();
    std::vector<const FieldDescriptor*> lists;
    r.ListFields(donor, &lists);
    std::erase_if(lists, [](const FieldDescriptor* field) {
        return !field->is_repeated() || field->cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE ||
               is_process_setting(field->name());
    });
    std::vector<std::string> sets;
    Config grown = config;
    std::set<std::string> wanted;
    const auto take = [&](const FieldDescriptor& list, const Message& element) {
        const int size = grown.GetReflection()->FieldSize(grown, &list);
        sets.push_back(list.name() + "[" + std::to_string(size) + "]=" + text_of(element));
        grown.GetReflection()->AddMessage(&grown, &list)->CopyFrom(element);
        collect_strings(element, wanted);
    };
    const auto has = [&](const FieldDescriptor& list, const std::string& name) {
        const Reflection& of_grown = *grown.GetReflection();
        for (int i = 0; i < of_grown.FieldSize(grown, &list); ++i) {
            if (name_of(of_grown.GetRepeatedMessage(grown, &list, i)) == name) {
                return true;
            }
        }
        return false;
    };
    const FieldDescriptor& first = *lists[rng.below(static_cast<std::uint32_t>(lists.size()))];
    const auto size = static_cast<std::uint32_t>(r.FieldSize(donor, &first));
    const Message& guest = r.GetRepeatedMessage(donor, &first, static_cast<int>(rng.below(size)));
    if (const std::string name = name_of(guest); !name.empty() && has(first, name)) {
        return {};
    }
    take(first, guest);
    for (bool more = true; more && sets.size() < kMostGuests;) {
        more = false;
        for (const FieldDescriptor* list : lists) {
            for (int i = 0; i < r.FieldSize(donor, list) && sets.size() < kMostGuests; ++i) {
                const Message& element = r.GetRepeatedMessage(donor, list, i);
                const std::string name = name_of(element);
                if (!name.empty() && wanted.contains(name) && !has(*list, name)) {
                    take(*list, element);
                    more = true;
                }
            }
        }
    }
    if (first.name() == "type") {
        sets.push_back("scatter[" + std::to_string(grown.scatter_size()) + "]={ type: \"" +
                       name_of(guest) + "\" count: " + std::to_string(1 + rng.below(12)) + " }");
    }
    return sets;
}

}  // namespace zoned::random_worlds
