// fuzzy_config: fuzzy systems of a config, in the form in which agents have them, and what is wrong
// with them.
#pragma once

#include "server/ai/decision/fuzzy/fuzzy_def.h"
#include "server/config/text/diagnostics.h"

#include <string>

namespace zoned::proto::config {
class Config;
class Fuzzy;
}  // namespace zoned::proto::config

namespace zoned::config {

/// Names that mean nothing become numbers that mean nothing.
ai::fuzzy::FuzzyDef expand_fuzzy(const proto::config::Fuzzy& fuzzy);

/// Inputs, terms, outputs and rules of one fuzzy system, which is at `path`.
void check_fuzzy_system(const proto::config::Fuzzy& fuzzy,
                        const std::string& path,
                        Diagnostics& diagnostics);

/// Fuzzy systems: names, terms, gaps, rules.
void check_fuzzy(const proto::config::Config& config, Diagnostics& diagnostics);

}  // namespace zoned::config
