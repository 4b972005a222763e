// Parts of behaviours: what a brain holds, copies of it for one type, and the transitions between
// the behaviours of a type.
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

/// Brains with all that is inside them, and the trees, domains and blends by which states choose,
/// by index.
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

/// Of the brain of that name, which exists.
BrainParts parts_of(const proto::config::Config& config, const std::string& brain);

/// Whether a parameter stands anywhere in it.
bool takes_parameters(const proto::config::Config& config, const std::string& brain);

/// Name of a brain that is `brain` with `values` in the place of parameters: itself, where it
/// takes none, or a copy with `prefix` before all names, appended to the config.
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
    bool remembers = false;  ///< its brain has more than one place to go on at
};

/// Adds to brain `index`, whose states are the last layer and then all others in order, the
/// transitions between them. Where a behaviour ends while a cue of another holds it goes there at
/// once, unless both exclude each other. Reports layers that never begin or never end.
void add_transitions(proto::config::Config& config,
                     int index,
                     const std::vector<BrainLayer>& layers,
                     Diagnostics& diagnostics,
                     const std::string& as);

}  // namespace zoned::config
