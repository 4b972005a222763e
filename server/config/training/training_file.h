// training_file: reads and checks the training file of `zoned train`, and reads and writes
// checkpoints.
#pragma once

#include "server/ai/learning/descent.h"
#include "server/ai/learning/evolution.h"
#include "server/config/text/config_error.h"
#include "proto/training.pb.h"
#include "shared/core/result.h"

#include <string>
#include <vector>

namespace zoned::config {

/// A checked training file; names of files are as opened.
struct TrainingPlan {
    proto::Training config;
    std::string digest;  ///< of all settings that decide the course of training
};

/// False with every mistake, by line and column.
bool load_training(const std::string& file, TrainingPlan& plan, std::vector<ConfigError>& errors);

/// The same of a text; names of files are relative to `folder`, and `file` gives the default names
/// of the files that are written.
bool parse_training(const std::string& text,
                    const std::string& file,
                    TrainingPlan& plan,
                    std::vector<ConfigError>& errors);

/// Breeding settings of networks for a task with these inputs and outputs; `config` is of method
/// GENETIC or NEAT.
ai::learning::BreedingSettings breeding_of(const proto::Training& config,
                                           std::size_t inputs,
                                           std::size_t outputs);

/// The layers that the file asks for, parameters 0.
ai::learning::NeuralNetwork layers_of(const proto::Training& config,
                                      std::size_t inputs,
                                      std::size_t outputs,
                                      ai::learning::Activation last);

/// The content of a checkpoint beside its digest: one of the two states by method.
void fill(const ai::learning::Evolution::EvolutionState& state, proto::TrainingCheckpoint& out);
void fill(const ai::learning::Descent::DescentState& state, proto::TrainingCheckpoint& out);

/// The reverse. Fails on a state that does not fit `shape` (GENETIC, GRADIENT), or is no sound
/// genome with these `inputs` and `outputs` (NEAT).
core::Result<ai::learning::Evolution::EvolutionState> evolution_state(
    const proto::TrainingCheckpoint& message,
    const ai::learning::BreedingSettings& settings,
    std::size_t inputs,
    std::size_t outputs);
core::Result<ai::learning::Descent::DescentState> descent_state(
    const proto::TrainingCheckpoint& message,
    std::size_t parameters);

/// Replaces the file at once or not at all: the new file is renamed when it is complete. Fails with
/// the reason.
core::Result<bool> write_whole(const std::string& file, const std::string& bytes);

/// A file of 8 bytes of magic, the payload's SHA-256 (hex) and the payload.
core::Result<bool> write_checkpoint(const std::string& file,
                                    const proto::TrainingCheckpoint& checkpoint);
core::Result<proto::TrainingCheckpoint> read_checkpoint(const std::string& file);

}  // namespace zoned::config
