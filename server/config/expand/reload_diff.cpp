#include "server/config/expand/reload_diff.h"

#include "server/config/expand/live_paths.h"
#include "server/config/settings.h"
#include "server/config/text/diagnostics.h"
#include "proto/config/config.pb.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/util/message_differencer.h>

#include <utility>

namespace zoned::config {

namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::util::MessageDifferencer;
using proto::config::Config;

/// The config without its agents, and without what the server process may change at any time.
Config without_brains(const Config& config) {
    Config rest = config;
    for (const std::string_view field : kBrainFields) {
        take_setting(field, nullptr, rest);
    }
    for (proto::config::Type& type : *rest.mutable_type()) {
        for (const std::string_view field : kTypeBrainFields) {
            take_setting(field, nullptr, type);
        }
    }
    for (const std::string_view path : kLivePaths) {
        take_setting(path, nullptr, rest);
    }
    return rest;
}

/// The first setting that differs, by path; empty: none.
std::string difference(const Message& a, const Message& b, const std::string& path) {
    const google::protobuf::Reflection& r = *a.GetReflection();
    for (int f = 0; f < a.GetDescriptor()->field_count(); ++f) {
        const FieldDescriptor& field = *a.GetDescriptor()->field(f);
        MessageDifferencer differencer;
        if (differencer.CompareWithFields(a, b, {&field}, {&field})) {
            continue;
        }
        const std::string here = join_path(path, field.name());
        if (field.cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE) {
            return here;
        }
        if (!field.is_repeated()) {
            const bool both = r.HasField(a, &field) && r.HasField(b, &field);
            return both ? difference(r.GetMessage(a, &field), r.GetMessage(b, &field), here) : here;
        }
        if (r.FieldSize(a, &field) != r.FieldSize(b, &field)) {
            return here;
        }
        for (int i = 0; i < r.FieldSize(a, &field); ++i) {
            const std::string inner = difference(r.GetRepeatedMessage(a, &field, i),
                                                 r.GetRepeatedMessage(b, &field, i),
                                                 join_path(path, field.name(), i));
            if (!inner.empty()) {
                return inner;
            }
        }
    }
    return {};
}

}  // namespace

core::Result<std::shared_ptr<const ai::AiSettings>> new_brains(const Settings& running,
                                                               const Settings& fresh) {
    using Reloaded = core::Result<std::shared_ptr<const ai::AiSettings>>;
    const std::string other =
        difference(without_brains(*running.config), without_brains(*fresh.config), "");
    if (!other.empty()) {
        return Reloaded::failure(
            other +
            " differs: only brains and scripts can be read anew, the rest takes a "
            "restart");
    }
    if (fresh.script.has_value() != running.script.has_value()) {
        return Reloaded::failure("script: rules of another kind take a restart");
    }
    for (std::size_t t = 0; t < fresh.types.size(); ++t) {
        if ((fresh.types[t].brain == 0) != (running.types[t].brain == 0)) {
            return Reloaded::failure(
                "type '" + fresh.types[t].name + "' " +
                (fresh.types[t].brain == 0 ? "loses its brain" : "gets a brain") +
                ": that takes a restart");
        }
    }
    auto brains = std::make_shared<ai::AiSettings>(fresh.ai);
    brains->brain_of_type.clear();
    for (const world::EntityType& type : fresh.types) {
        brains->brain_of_type.push_back(type.brain);
    }
    return Reloaded(std::shared_ptr<const ai::AiSettings>(std::move(brains)));
}

}  // namespace zoned::config
