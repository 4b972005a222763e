#include "server/app/commands/commands.h"
#include "server/app/training/trainer.h"
#include "server/compute/worker_pool.h"
#include "server/config/text/config_error.h"
#include "server/config/training/policy_file.h"

#include <csignal>
#include <cstdio>
#include <filesystem>

namespace zoned::app {

namespace {

volatile std::sig_atomic_t interrupted = 0;

/// While it lives SIGINT and SIGTERM ask training to end instead of ending the program.
class InterruptWatch {
  public:
    InterruptWatch() {
        interrupted = 0;
        int_before_ = std::signal(SIGINT, note);
        term_before_ = std::signal(SIGTERM, note);
    }

    ~InterruptWatch() {
        std::signal(SIGINT, int_before_);
        std::signal(SIGTERM, term_before_);
    }

    InterruptWatch(const InterruptWatch&) = delete;
    InterruptWatch& operator=(const InterruptWatch&) = delete;

    [[nodiscard]] static bool asked() { return interrupted != 0; }

  private:
    static void note(int /*signal*/) { interrupted = 1; }

    using Handler = void (*)(int);
    Handler int_before_ = SIG_DFL;
    Handler term_before_ = SIG_DFL;
};

int complain(const std::string& text, int code) {
    std::fprintf(stderr, "zoned: %s\n", text.c_str());
    return code;
}

/// 0, or the exit code after printing the mistake.
int go_on_from_checkpoint(const config::TrainingPlan& plan, Trainer& trainer) {
    const std::string& file = plan.config.checkpoint_file();
    const auto checkpoint = config::read_checkpoint(file);
    if (!checkpoint) {
        return complain(checkpoint.error(), kEnvironment);
    }
    if (checkpoint->training_digest() != plan.digest) {
        return complain(file +
                            ": is of another training: only rounds, target_score and names of "
                            "files may change; --restart begins anew",
                        kUsage);
    }
    const auto restored = trainer.restore(*checkpoint);
    if (!restored) {
        return complain(file + ": " + restored.error(), kUsage);
    }
    std::fprintf(
        stderr, "goes on after round %llu\n", static_cast<unsigned long long>(trainer.rounds()));
    return kGood;
}

bool save(const config::TrainingPlan& plan, const Trainer& trainer) {
    proto::TrainingCheckpoint checkpoint;
    trainer.save(checkpoint);
    checkpoint.set_training_digest(plan.digest);
    const auto written = config::write_checkpoint(plan.config.checkpoint_file(), checkpoint);
    if (!written) {
        complain(written.error(), kEnvironment);
    }
    return written.ok();
}

bool reached(const config::TrainingPlan& plan, const Trainer& trainer) {
    return plan.config.has_target_score() && trainer.rounds() > 0 &&
           trainer.score() >= plan.config.target_score();
}

/// Rounds until the end, the target or a signal; false when a checkpoint could not be written.
bool train_on(const config::TrainingPlan& plan, Trainer& trainer, unsigned threads) {
    compute::WorkerPool pool(threads);
    compute::Team team;
    team.join_pool(pool);
    const compute::Team::Shift shift(team);
    const ai::learning::RunRanges run = [&team](std::size_t count, const auto& work) {
        team.run(count, 1, work);
    };
    const std::uint64_t every = plan.config.checkpoint_every();
    while (trainer.rounds() < plan.config.rounds() && !reached(plan, trainer) &&
           !InterruptWatch::asked()) {
        trainer.round(run);
        const bool last = trainer.rounds() == plan.config.rounds() || reached(plan, trainer) ||
                          InterruptWatch::asked();
        if (trainer.rounds() % every == 0 || last || trainer.rounds() == 1) {
            std::fprintf(stderr, "%s\n", trainer.progress().c_str());
        }
        if ((trainer.rounds() % every == 0 || last) && !save(plan, trainer)) {
            return false;
        }
    }
    return true;
}

int finish(const config::TrainingPlan& plan, const Trainer& trainer) {
    const proto::Training& config = plan.config;
    const std::string how = "task " + proto::Training::Task_Name(config.task()) + ", method " +
                            proto::Training::Method_Name(config.method()) + ", seed " +
                            std::to_string(config.seed()) + ", " +
                            std::to_string(trainer.rounds()) + " rounds";
    const auto written =
        config::write_whole(config.policy_file(), config::policy_text(trainer.policy(), how));
    if (!written) {
        return complain(written.error(), kEnvironment);
    }
    std::printf("%s%s: policy '%s', %zu nodes, %s\n",
                trainer.summary().c_str(),
                config.policy_file().c_str(),
                config.name().c_str(),
                trainer.policy().network.nodes.size(),
                how.c_str());
    if (config.has_target_score() && trainer.score() < config.target_score()) {
        return complain("the target score " + std::to_string(config.target_score()) +
                            " was not reached: more rounds and --resume go on from here",
                        kFailed);
    }
    return kGood;
}

}  // namespace

int train(const TrainArguments& arguments) {
    config::TrainingPlan plan;
    std::vector<config::ConfigError> errors;
    if (!config::load_training(arguments.file, plan, errors)) {
        std::fputs(config::format_errors(arguments.file, errors).c_str(), stderr);
        return complain(std::to_string(errors.size()) + " mistake" +
                            (errors.size() == 1 ? "" : "s") + " in " + arguments.file +
                            "; nothing was trained",
                        kUsage);
    }
    const std::string& checkpoint = plan.config.checkpoint_file();
    if (!arguments.resume && !arguments.restart && std::filesystem::exists(checkpoint)) {
        return complain(checkpoint +
                            " is there from a training before: --resume goes on from it, "
                            "--restart begins anew",
                        kUsage);
    }
    const auto trainer = make_trainer(plan);
    if (!trainer) {
        return complain(trainer.error(), kEnvironment);
    }
    if (arguments.resume) {
        const int code = go_on_from_checkpoint(plan, **trainer);
        if (code != kGood) {
            return code;
        }
    }
    const InterruptWatch watch;
    if (!train_on(plan, **trainer, arguments.threads)) {
        return kEnvironment;
    }
    if (InterruptWatch::asked()) {
        std::printf("interrupted after round %llu; zoned train %s --resume goes on\n",
                    static_cast<unsigned long long>((*trainer)->rounds()),
                    arguments.file.c_str());
        return save(plan, **trainer) ? kGood : kEnvironment;
    }
    return finish(plan, **trainer);
}

}  // namespace zoned::app
