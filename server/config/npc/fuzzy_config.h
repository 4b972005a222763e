// fuzzy_config: reads and checks the fuzzy systems of a config for agents.
#pragma once

#include "server/ai/decision/fuzzy/fuzzy_def.h"
#include "server/config/text/diagnostics.h"

#include <string>

namespace zoned::proto::config {
class Config;
class Fuzzy;
}  // namespace zoned::proto::config

namespace zoned::config {

/// Unknown names become invalid numbers.
ai::fuzzy::FuzzyDef expand_fuzzy(const proto::config::Fuzzy& fuzzy);

/// Checks inputs, terms, outputs and rules of one fuzzy system, which is at `path`.
void check_fuzzy_system(const proto::config::Fuzzy& fuzzy,
                        const std::string& path,
                        Diagnostics& diagnostics);

/// Checks fuzzy systems: names, terms, gaps, rules.
void check_fuzzy(const proto::config::Config& config, Diagnostics& diagnostics);

}  // namespace zoned::config
