// assembly_config: types of several bodies: their parts become types of their own, their joints
// plans.
#pragma once

#include "server/config/text/diagnostics.h"

namespace zoned::proto::config {
class Config;
}  // namespace zoned::proto::config

namespace zoned::config {

struct Settings;

/// Gives a type with assembly { ... } the shape and mass of its first part, and adds a type
/// TYPE.PART for each other one. Types are complete (see resolve_types). Mistakes in what was made
/// are reported at the part. Reports names, shapes, and settings that belong to one body alone.
void make_part_types(proto::config::Config& config, Diagnostics& diagnostics);

/// Fills settings.assemblies, and says in settings.types whose parts they are. Reports joints,
/// seats and controls that do not fit. Needs settings.types and settings.solids.
void expand_assemblies(const proto::config::Config& config,
                       Settings& settings,
                       Diagnostics& diagnostics);

}  // namespace zoned::config
