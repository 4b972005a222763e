#include "server/app/training/trainer.h"

#include "server/ai/learning/arena.h"
#include "server/ai/learning/cart_pole.h"
#include "server/ai/learning/evolution.h"
#include "server/ai/learning/xor_task.h"
#include "server/app/training/imitation.h"
#include "server/config/training/policy_file.h"
#include "shared/core/print.h"

#include <utility>

namespace zoned::app {

namespace {

namespace learning = ai::learning;
using proto::Training;
using Made = core::Result<std::unique_ptr<Trainer>>;
using Restored = core::Result<bool>;

using core::print;

learning::Arena arena_of(const Training::Arena& from) {
    learning::Arena arena;
    arena.wall_m = static_cast<float>(from.wall_m());
    arena.goal_reach_m = static_cast<float>(from.goal_reach_m());
    arena.speed = static_cast<float>(from.speed_mps());
    arena.goal_speed = static_cast<float>(from.goal_speed_mps());
    return arena;
}

std::unique_ptr<learning::Task> task_of(const Training& config) {
    switch (config.task()) {
        case Training::CART_POLE:
            return std::make_unique<learning::CartPoleTask>();
        case Training::ARENA:
            return std::make_unique<learning::ArenaTask>(arena_of(config.arena()));
        case Training::XOR:
        case Training::IMITATION:  // is no task to breed for
            break;
    }
    return std::make_unique<learning::XorTask>();
}

/// A population that is bred.
class BreedingTrainer final : public Trainer {
  public:
    explicit BreedingTrainer(const config::TrainingPlan& plan)
        : config_(plan.config),
          task_(task_of(config_)),
          settings_(config::breeding_of(config_, task_->inputs(), task_->outputs())),
          evolution_(*task_, settings_, config_.seed()) {}

    void round(const learning::RunRanges& run) override { evolution_.step(run); }

    [[nodiscard]] std::uint64_t rounds() const override { return evolution_.generation(); }

    [[nodiscard]] double score() const override { return evolution_.score(); }

    [[nodiscard]] std::string progress() const override {
        return print("generation %llu: fittest %.6g, best score %.6g, %zu nodes, %zu species",
                     static_cast<unsigned long long>(evolution_.generation()),
                     evolution_.fitness(),
                     evolution_.score(),
                     evolution_.best().nodes.size(),
                     evolution_.species());
    }

    [[nodiscard]] std::string summary() const override {
        // The best was chosen by its score on one course: another one judges.
        const std::uint64_t unseen = core::mix(~config_.seed());
        std::string text = print(
            "score %.6g where it was chosen, %.6g on circumstances that it "
            "never saw; %.6g counts as solved\n",
            evolution_.score(),
            task_->score(evolution_.best(), unseen),
            task_->solved_at());
        if (const auto* arena = dynamic_cast<const learning::ArenaTask*>(task_.get())) {
            text += print("who walks straight at the goal there: %.6g\n",
                          learning::straight_score(arena->arena(), unseen));
        }
        return text;
    }

    [[nodiscard]] learning::Policy policy() const override {
        learning::Policy policy;
        if (const auto* arena = dynamic_cast<const learning::ArenaTask*>(task_.get())) {
            policy = learning::arena_policy(arena->arena(), evolution_.best());
        } else {
            policy.network = evolution_.best();
        }
        policy.name = config_.name();
        return policy;
    }

    void save(proto::TrainingCheckpoint& out) const override {
        config::fill(evolution_.state(), out);
    }

    Restored restore(const proto::TrainingCheckpoint& from) override {
        auto state = config::evolution_state(from, settings_, task_->inputs(), task_->outputs());
        if (!state) {
            return Restored::failure(state.error());
        }
        evolution_.restore(std::move(*state));
        return true;
    }

  private:
    Training config_;
    std::unique_ptr<learning::Task> task_;
    learning::BreedingSettings settings_;
    learning::Evolution evolution_;
};

/// A network that is fitted to the actions of players.
class ImitationTrainer final : public Trainer {
  public:
    ImitationTrainer(const config::TrainingPlan& plan, Lessons lessons)
        : config_(plan.config),
          lessons_(std::move(lessons)),
          network_(config::layers_of(config_,
                                     lessons_.training.inputs,
                                     lessons_.training.outputs,
                                     learning::Activation::kLinear)),
          descent_({static_cast<float>(config_.gradient().step()), config_.gradient().batch()},
                   network_,
                   config_.seed()) {
        core::Rng rng(config_.seed(), 0x1417A7E);
        randomise(network_, rng);
    }

    void round(const learning::RunRanges& /*run*/) override {
        training_error_ = descent_.epoch(network_, lessons_.training);
        ++rounds_;
    }

    [[nodiscard]] std::uint64_t rounds() const override { return rounds_; }

    [[nodiscard]] double score() const override {
        return 1.0 - mean_squared_error(network_, lessons_.held_out) /
                         error_of_best_constant(lessons_.held_out);
    }

    [[nodiscard]] std::string progress() const override {
        return print("pass %llu: squared error %.6g on the way, score %.4f on players held out",
                     static_cast<unsigned long long>(rounds_),
                     training_error_,
                     score());
    }

    [[nodiscard]] std::string summary() const override {
        return print(
            "%zu samples of %zu players; %zu of %zu players held out: squared error %.4f, "
            "the best constant's %.4f\n",
            lessons_.training.size(),
            lessons_.players - lessons_.players_held_out,
            lessons_.held_out.size(),
            lessons_.players_held_out,
            mean_squared_error(network_, lessons_.held_out),
            error_of_best_constant(lessons_.held_out));
    }

    [[nodiscard]] learning::Policy policy() const override {
        learning::Policy policy;
        policy.name = config_.name();
        policy.facing = static_cast<learning::Facing>(config_.imitation().facing());
        policy.inputs = config::inputs_of(config_.imitation().input());
        policy.network = network_;
        return policy;
    }

    void save(proto::TrainingCheckpoint& out) const override {
        out.set_samples_hash(lessons_.hash);
        out.set_round(rounds_);
        out.set_fitness(training_error_);
        *out.mutable_best() = config::message_of(network_);
        config::fill(descent_.state(), out);
    }

    Restored restore(const proto::TrainingCheckpoint& from) override {
        auto network = config::network_of(from.best());
        auto state = config::descent_state(from, network_.parameters.size());
        if (!network || !state) {
            return Restored::failure(network ? state.error() : network.error());
        }
        if (from.samples_hash() != lessons_.hash || network->source != network_.source) {
            return Restored::failure("it is of another recording or network");
        }
        network_ = std::move(*network);
        descent_.restore(std::move(*state));
        rounds_ = from.round();
        training_error_ = from.fitness();
        return true;
    }

  private:
    Training config_;
    Lessons lessons_;
    learning::NeuralNetwork network_;
    learning::Descent descent_;
    std::uint64_t rounds_ = 0;
    double training_error_ = 0.0;
};

}  // namespace

Made make_trainer(const config::TrainingPlan& plan) {
    if (plan.config.task() != Training::IMITATION) {
        return Made(std::make_unique<BreedingTrainer>(plan));
    }
    const Training::Imitation& imitation = plan.config.imitation();
    const auto ticks = played_ticks(imitation, imitation.every_ticks());
    if (!ticks) {
        return Made::failure(ticks.error());
    }
    auto lessons = lessons_of(*ticks, imitation);
    if (!lessons) {
        return Made::failure(lessons.error());
    }
    return Made(std::make_unique<ImitationTrainer>(plan, std::move(*lessons)));
}

}  // namespace zoned::app
