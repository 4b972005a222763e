// behaviour_parts: the parts of a behaviour's brain, their copies for one type, and the transitions
// between a type's behaviours.
#pragma once

#include "server/config/npc/parameters.h"
#include "server/config/text/diagnostics.h"
#include "proto/config/brains.pb.h"

#include <functional>
#include <set>
#include <string>
#include <vector>

namespace zoned::proto::config {
class Config;
}  // namespace zoned::proto::config

namespace zoned::config {

/// A brain, tree, domain or blend, and its path.
using LookAtPart =
    std::function<void(const google::protobuf::Message& part, const std::string& path)>;

/// A brain with the brains inside it, and the trees, domains and blends of its states, by index.
struct BrainParts {
    std::set<int> brains;
    std::set<int> trees;
    std::set<int> domains;
    std::set<int> blends;

    void merge(BrainParts other) {
        brains.merge(other.brains);
        trees.merge(other.trees);
        domains.merge(other.domains);
        blends.merge(other.blends);
    }

    /// Calls `work` for each.
    void for_each(const proto::config::Config& config, const LookAtPart& work) const;
};

/// Parts of the brain of that name, which exists.
BrainParts parts_of(const proto::config::Config& config, const std::string& brain);

/// Whether any of its settings takes a parameter.
bool takes_parameters(const proto::config::Config& config, const std::string& brain);

/// Name of `brain` with `values` in place of parameters. A brain without parameters keeps its name.
/// Otherwise a copy with `prefix` before all names is appended to the config.
std::string copy_with_parameters(proto::config::Config& config,
                                 const std::string& brain,
                                 const std::string& prefix,
                                 const ParameterValues& values,
                                 Diagnostics& diagnostics,
                                 const std::string& as);

/// A behaviour of a type, with the type's numbers.
struct BrainLayer {
    proto::config::Behaviour part;
    std::string path;        ///< of the behaviour
    std::string use_path;    ///< of the type's setting that names it
    bool remembers = false;  ///< its brain has more than one state in which to go on
};

/// Adds to brain `index`, whose states are the last layer and then all others in order, the
/// transitions between them. A behaviour that ends while a cue of another holds passes to that one
/// at once, unless both exclude each other. Reports layers that never begin or never end.
void add_transitions(proto::config::Config& config,
                     int index,
                     const std::vector<BrainLayer>& layers,
                     Diagnostics& diagnostics,
                     const std::string& as);

}  // namespace zoned::config
