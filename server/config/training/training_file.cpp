#include "server/config/training/training_file.h"

#include "server/config/text/config_numbers.h"
#include "server/config/text/config_set.h"
#include "server/config/text/config_text.h"
#include "server/config/text/read_text.h"
#include "server/config/text/sha256.h"

#include <google/protobuf/text_format.h>

#include <algorithm>
#include <cstring>
#include <filesystem>

namespace zoned::config {

namespace {

namespace learning = ai::learning;
using proto::Training;

/// A block that the method or task does not use is most likely a mistake about them.
void check_blocks(const Training& config, Diagnostics& diagnostics) {
    const std::string method = Training::Method_Name(config.method());
    const std::string task = Training::Task_Name(config.task());
    const auto unused = [&](bool given, bool used, const char* field, const std::string& by) {
        if (given && !used) {
            diagnostics.add(field, "has no meaning for " + by);
        }
    };
    unused(
        config.has_genetic(), config.method() == Training::GENETIC, "genetic", "method " + method);
    unused(config.has_neat(), config.method() == Training::NEAT, "neat", "method " + method);
    unused(config.has_gradient(),
           config.method() == Training::GRADIENT,
           "gradient",
           "method " + method);
    unused(config.hidden_size() > 0,
           config.method() != Training::NEAT,
           "hidden[0]",
           "method NEAT, which grows its own nodes");
    unused(config.has_arena(), config.task() == Training::ARENA, "arena", "task " + task);
    const bool imitates = config.task() == Training::IMITATION;
    unused(config.has_imitation(), imitates, "imitation", "task " + task);
    unused(
        config.has_target_score(), !imitates, "target_score", "task IMITATION: all rounds are run");
    if (imitates != (config.method() == Training::GRADIENT)) {
        diagnostics.add(config.has_method() ? "method" : "task",
                        imitates ? "task IMITATION is learned by method GRADIENT"
                                 : "method GRADIENT needs samples of what is right: task " + task +
                                       " has none, use GENETIC or NEAT");
    }
}

void check_imitation(const Training& config, Diagnostics& diagnostics) {
    if (config.task() != Training::IMITATION) {
        return;
    }
    const Training::Imitation& imitation = config.imitation();
    if (!imitation.has_recording()) {
        diagnostics.add(config.has_imitation() ? "imitation" : "task",
                        "task IMITATION needs imitation { recording: \"FILE\" }");
    }
    if (imitation.input_size() == 0) {
        diagnostics.add(config.has_imitation() ? "imitation" : "task",
                        "a policy needs at least one input { ego: ... }");
    }
    for (int i = 0; i < imitation.input_size(); ++i) {
        if (imitation.input(i).has_variable()) {
            diagnostics.add(join_path("imitation", "input", i) + ".variable",
                            "players have no variables: use ego");
        }
    }
}

void check_training(const Training& config, Diagnostics& diagnostics) {
    check_blocks(config, diagnostics);
    check_imitation(config, diagnostics);
    if (config.genetic().elite() >= config.genetic().population()) {
        diagnostics.add("genetic.elite",
                        "is " + std::to_string(config.genetic().elite()) + "; of a population of " +
                            std::to_string(config.genetic().population()) +
                            " at least one must be bred");
    }
    if (config.arena().goal_speed_mps() > config.arena().speed_mps()) {
        diagnostics.add("arena.goal_speed_mps", "is above speed_mps: nobody would reach the goal");
    }
}

/// All settings except those that may change when training goes on.
std::string course_digest(Training config) {
    config.clear_rounds();
    config.clear_target_score();
    config.clear_policy_file();
    config.clear_checkpoint_file();
    config.clear_checkpoint_every();
    std::string text;
    google::protobuf::TextFormat::PrintToString(config, &text);
    return sha256_hex(text);
}

void resolve_names(const std::string& file, Training& config) {
    const std::filesystem::path folder = std::filesystem::path(file).parent_path();
    const auto resolved = [&folder](const std::string& name) {
        return (folder / name).string();  // an absolute name stays as it is
    };
    config.set_policy_file(config.has_policy_file() ? resolved(config.policy_file())
                                                    : file + ".policy");
    config.set_checkpoint_file(config.has_checkpoint_file() ? resolved(config.checkpoint_file())
                                                            : file + ".checkpoint");
    if (config.imitation().has_recording()) {
        config.mutable_imitation()->set_recording(resolved(config.imitation().recording()));
    }
}

}  // namespace

bool parse_training(const std::string& text,
                    const std::string& file,
                    TrainingPlan& plan,
                    std::vector<ConfigError>& errors) {
    Diagnostics diagnostics;
    plan = TrainingPlan();
    const bool complete = parse_config_text(text, plan.config, diagnostics);
    check_ranges(plan.config, complete, diagnostics);
    if (complete) {
        diagnostics.silence_reported_lines();
        check_training(plan.config, diagnostics);
    }
    errors = diagnostics.sorted();
    if (!errors.empty()) {
        return false;
    }
    plan.digest = course_digest(plan.config);
    resolve_names(file, plan.config);
    return true;
}

bool load_training(const std::string& file, TrainingPlan& plan, std::vector<ConfigError>& errors) {
    std::string text;
    const std::string wrong = read_text(file, text);
    if (!wrong.empty()) {
        errors = {{0, 0, "", wrong}};
        return false;
    }
    return parse_training(text, file, plan, errors);
}

learning::NeuralNetwork layers_of(const Training& config,
                                  std::size_t inputs,
                                  std::size_t outputs,
                                  learning::Activation last) {
    std::vector<std::size_t> layers{inputs};
    for (const Training::Layer& layer : config.hidden()) {
        layers.push_back(layer.nodes());
    }
    layers.push_back(outputs);
    return learning::dense(layers, last);
}

learning::BreedingSettings breeding_of(const Training& config,
                                       std::size_t inputs,
                                       std::size_t outputs) {
    if (config.method() == Training::NEAT) {
        const Training::Neat& from = config.neat();
        learning::NeatSettings neat;
        neat.population = from.population();
        neat.threshold = narrow(from.threshold());
        neat.add_node = narrow(from.add_node());
        neat.add_link = narrow(from.add_link());
        neat.perturbation = narrow(from.perturbation());
        return neat;
    }
    const Training::Genetic& from = config.genetic();
    learning::FixedTopology fixed;
    fixed.shape = layers_of(config, inputs, outputs, learning::Activation::kSquash);
    fixed.spread = narrow(from.spread());
    fixed.genetic = {from.population(),
                     from.elite(),
                     from.tournament(),
                     narrow(from.crossover()),
                     narrow(from.mutation()),
                     narrow(from.mutation_scale())};
    return fixed;
}

}  // namespace zoned::config
