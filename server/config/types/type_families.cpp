#include "server/config/types/type_families.h"

#include "proto/config/config.pb.h"

#include <google/protobuf/descriptor.h>

#include <algorithm>
#include <memory>
#include <optional>

namespace zoned::config {

namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using proto::config::Config;

/// Settings of `over` override those of `out`; lists are replaced as a whole.
void overlay(const Message& over, Message& out) {
    const google::protobuf::Reflection& reflection = *over.GetReflection();
    const std::unique_ptr<Message> rest(over.New());
    rest->CopyFrom(over);
    std::vector<const FieldDescriptor*> fields;
    reflection.ListFields(over, &fields);
    for (const FieldDescriptor* field : fields) {
        if (field->is_repeated()) {
            reflection.ClearField(&out, field);
        } else if (field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE &&
                   reflection.HasField(out, field)) {
            overlay(reflection.GetMessage(over, field), *reflection.MutableMessage(&out, field));
            reflection.ClearField(rest.get(), field);
        }
    }
    out.MergeFrom(*rest);
}

class TypeFamilies {
  public:
    TypeFamilies(const Config& config, Diagnostics& diagnostics)
        : config_(config),
          diagnostics_(diagnostics),
          done_(static_cast<std::size_t>(config.type_size())) {}

    struct Resolved {
        proto::config::Type type;
        std::vector<BehaviourUse> uses;
    };

    const Resolved& resolve(int index) {
        std::optional<Resolved>& done = done_[static_cast<std::size_t>(index)];
        if (done) {
            return *done;
        }
        const proto::config::Type& own = config_.type(index);
        const std::string path = join_path("", "type", index);
        Resolved out;
        path_.push_back(index);
        const int base = base_of(own, path);
        if (base >= 0) {
            out = resolve(base);
        }
        path_.pop_back();
        if (own.has_brain()) {
            out.uses.clear();
        }
        if (own.behaviour_size() > 0) {
            out.type.clear_brain();
            if (own.has_brain()) {
                diagnostics_.add(path, "takes one of `brain` and `behaviour`");
            }
        }
        add_uses(own, path, out.uses);
        proto::config::Type over = own;
        over.clear_base();
        over.clear_behaviour();
        out.type.clear_name();
        overlay(over, out.type);
        done = std::move(out);
        return *done;
    }

  private:
    /// Index of the base; -1 without a usable base.
    int base_of(const proto::config::Type& type, const std::string& path) {
        if (!type.has_base()) {
            return -1;
        }
        const auto& types = config_.type();
        const auto at =
            std::find_if(types.begin(), types.end(), [&](const proto::config::Type& other) {
                return other.name() == type.base();
            });
        if (at == types.end()) {
            diagnostics_.add(path + ".base", "there is no type named '" + type.base() + "'");
            diagnostics_.silence_line_of(path);  // what it lacks, it lacks for that
            return -1;
        }
        const int base = static_cast<int>(at - types.begin());
        const auto seen = std::find(path_.begin(), path_.end(), base);
        if (seen == path_.end()) {
            return base;
        }
        std::string names;
        for (auto on = seen; on != path_.end(); ++on) {
            names += "'" + config_.type(*on).name() + "' is like ";
        }
        diagnostics_.add(path + ".base",
                         "a type cannot be its own base: " + names + "'" + type.base() + "'");
        diagnostics_.silence_line_of(path);
        return -1;
    }

    void add_uses(const proto::config::Type& own,
                  const std::string& path,
                  std::vector<BehaviourUse>& uses) {
        std::size_t front = 0;
        std::vector<std::string> named;
        for (int b = 0; b < own.behaviour_size(); ++b) {
            const proto::config::TypeBehaviour& from = own.behaviour(b);
            const std::string here = join_path(path, "behaviour", b);
            if (std::find(named.begin(), named.end(), from.name()) != named.end()) {
                diagnostics_.add(here + ".name",
                                 "the type has '" + from.name() + "' already: say it all there");
                continue;
            }
            named.push_back(from.name());
            std::size_t at = find(uses, from.name());
            if (from.remove()) {
                if (at == uses.size()) {
                    diagnostics_.add(here + ".remove",
                                     "its base has no behaviour '" + from.name() + "'");
                } else {
                    front -= at < front ? 1 : 0;
                    uses.erase(uses.begin() + static_cast<std::ptrdiff_t>(at));
                }
                continue;
            }
            BehaviourUse use;
            const bool fresh = at == uses.size();
            if (fresh) {
                use.name = from.name();
                use.path = here;
                at = front++;
            } else {
                use = uses[at];
                uses.erase(uses.begin() + static_cast<std::ptrdiff_t>(at));
            }
            if (from.has_before()) {
                front -= fresh || at < front ? 1 : 0;
                at = find(uses, from.before());
                if (at == uses.size()) {
                    diagnostics_.add(here + ".before",
                                     "the type has no behaviour '" + from.before() + "' so far");
                }
                front += at < front ? 1 : 0;
            }
            add_values(own, from, here, use);
            uses.insert(uses.begin() + static_cast<std::ptrdiff_t>(at), std::move(use));
        }
    }

    void add_values(const proto::config::Type& own,
                    const proto::config::TypeBehaviour& from,
                    const std::string& here,
                    BehaviourUse& use) {
        std::vector<std::string> named;
        for (int v = 0; v < from.set_size(); ++v) {
            const std::string at = join_path(here, "set", v);
            const std::string& name = from.set(v).name();
            if (std::find(named.begin(), named.end(), name) != named.end()) {
                diagnostics_.add(at + ".name", "'" + name + "' is set already");
            }
            named.push_back(name);
            use.set[name] = {from.set(v).value(), at, own.name()};
        }
    }

    static std::size_t find(const std::vector<BehaviourUse>& uses, const std::string& name) {
        return static_cast<std::size_t>(
            std::find_if(uses.begin(), uses.end(), [&](const auto& u) { return u.name == name; }) -
            uses.begin());
    }

    const Config& config_;
    Diagnostics& diagnostics_;
    std::vector<std::optional<Resolved>> done_;
    std::vector<int> path_;  ///< types that are being resolved, each the base of the one before it
};

}  // namespace

BehaviourUses resolve_types(proto::config::Config& config, Diagnostics& diagnostics) {
    BehaviourUses uses(static_cast<std::size_t>(config.type_size()));
    const auto plain = [](const proto::config::Type& type) {
        return !type.has_base() && type.behaviour_size() == 0;
    };
    if (std::all_of(config.type().begin(), config.type().end(), plain)) {
        return uses;
    }
    const Config written = config;
    TypeFamilies families(written, diagnostics);
    for (int t = 0; t < config.type_size(); ++t) {
        const TypeFamilies::Resolved& resolved = families.resolve(t);
        *config.mutable_type(t) = resolved.type;
        uses[static_cast<std::size_t>(t)] = resolved.uses;
    }
    return uses;
}

}  // namespace zoned::config
