// joint_config: turns a joint { ... } of the config into a plan that zones carry out.
#pragma once

#include "server/config/text/diagnostics.h"
#include "server/zone/assemblies/assembly_def.h"

#include <memory>
#include <string>

namespace zoned::proto::config {
class Joint;
}  // namespace zoned::proto::config

namespace zoned::config {

/// How the axes of a body lie in those in which the config describes it: identity but for hulls and
/// compounds (world::EntityType::stands of the shape alone).
struct JointEnds {
    Quat stands_a = Quat::Identity();
    Quat stands_b = Quat::Identity();
    bool to_world = false;  ///< `a` is not set
};

/// The plan of a joint whose bodies were found. Mistakes are reported at `path`; null then.
std::shared_ptr<const zone::JointPlan> read_joint(const proto::config::Joint& from,
                                                  const JointEnds& ends,
                                                  const std::string& path,
                                                  Diagnostics& diagnostics);

}  // namespace zoned::config
