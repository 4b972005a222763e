// Trainer: a training in progress, round by round, for any subject and method of learning.
#pragma once

#include "server/ai/learning/policy.h"
#include "server/ai/learning/task.h"
#include "server/config/training/training_file.h"
#include "shared/core/result.h"

#include <memory>
#include <string>

namespace zoned::app {

class Trainer {
  public:
    Trainer() = default;
    Trainer(const Trainer&) = delete;
    Trainer& operator=(const Trainer&) = delete;
    virtual ~Trainer() = default;

    /// One more generation, or pass over all samples.
    virtual void round(const ai::learning::RunRanges& run) = 0;
    [[nodiscard]] virtual std::uint64_t rounds() const = 0;
    /// Of the best so far, on samples held out from training; more is better.
    [[nodiscard]] virtual double score() const = 0;
    /// A line about the last round.
    [[nodiscard]] virtual std::string progress() const = 0;
    /// Lines about the best so far, for the end.
    [[nodiscard]] virtual std::string summary() const = 0;
    [[nodiscard]] virtual ai::learning::Policy policy() const = 0;

    virtual void save(proto::TrainingCheckpoint& out) const = 0;
    /// Goes on as the training that was saved; fails on the data of another one.
    virtual core::Result<bool> restore(const proto::TrainingCheckpoint& from) = 0;
};

/// Fails where a recording cannot be learned from.
core::Result<std::unique_ptr<Trainer>> make_trainer(const config::TrainingPlan& plan);

}  // namespace zoned::app
