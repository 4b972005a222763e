// Fuzzing of the readers of training: any text is a training file, a policy, or neither with a
// reason given. A checkpoint of any content is taken or refused.
#include "server/config/text/config_error.h"
#include "server/config/training/policy_file.h"
#include "server/config/training/training_file.h"
#include "tests/fuzz/fuzz.h"
#include "shared/core/assert.h"

#include <google/protobuf/stubs/logging.h>

#include <array>
#include <fstream>
#include <iterator>

namespace zoned::fuzz {

namespace {

namespace learning = ai::learning;

constexpr std::size_t kMaxBytes = 32768;

void try_policy(const std::string& text) {
    const auto policy = config::parse_policy(text);
    if (!policy) {
        ZONED_ASSERT(!policy.error().empty(), "a refusal has a reason");
        return;
    }
    std::vector<float> values(policy->network.values());
    std::array<float, learning::kMostInputs> variables{};
    const learning::Wanted wanted = decide(*policy, {}, variables, values);
    ZONED_ASSERT(!(wanted.move.norm() > 1.001F), "nobody wants more than all");
}

/// A network of any message, without the digest that a policy file has.
void try_network(const std::string& bytes) {
    proto::FlatNetwork message;
    if (!message.ParseFromString(bytes)) {
        return;
    }
    const auto network = config::network_of(message);
    if (network) {
        std::vector<float> in(network->inputs, 0.5F);
        std::vector<float> values(network->values());
        std::vector<float> out(network->outputs.size());
        evaluate(*network, in, values, out);
    }
}

void try_checkpoint(const std::string& bytes) {
    proto::TrainingCheckpoint message;
    if (!message.ParseFromString(bytes)) {
        return;
    }
    proto::Training config;
    config.set_method(proto::Training::NEAT);
    config.mutable_neat()->set_population(2);
    auto grown = config::evolution_state(message, config::breeding_of(config, 2, 1), 2, 1);
    if (grown) {
        learning::Neat neat(
            std::get<learning::NeatSettings>(config::breeding_of(config, 2, 1)), 2, 1, 1);
        neat.restore(std::move(std::get<learning::Neat::NeatState>(grown->population)));
        neat.breed(std::array{1.0, 2.0});
    }
    config.set_method(proto::Training::GENETIC);
    (void)config::evolution_state(message, config::breeding_of(config, 2, 1), 2, 1);
    (void)config::descent_state(message, 5);
}

void add(std::vector<Bytes>& all, const std::string& bytes) {
    all.emplace_back(bytes.begin(), bytes.end());
}

}  // namespace

std::vector<Bytes> seeds() {
    std::vector<Bytes> all;
    for (const char* name :
         {"arena.txtpb", "cart_pole.txtpb", "hunter.txtpb", "arena.policy", "arena_neat.policy"}) {
        std::ifstream in(std::string(ZONED_SOURCE_DIR "/config/training/") + name,
                         std::ios::binary);
        all.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
    }
    proto::Training config;
    config.set_method(proto::Training::NEAT);
    config.mutable_neat()->set_population(2);
    const learning::Neat neat(
        std::get<learning::NeatSettings>(config::breeding_of(config, 2, 1)), 2, 1, 1);
    learning::Evolution::EvolutionState state;
    state.population = neat.state();
    state.best = network_of(neat.genomes()[0]);
    proto::TrainingCheckpoint checkpoint;
    config::fill(state, checkpoint);
    add(all, checkpoint.SerializeAsString());
    add(all, config::message_of(state.best).SerializeAsString());
    return all;
}

}  // namespace zoned::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace zoned;
    google::protobuf::SetLogHandler(nullptr);  // as the program does
    const std::string bytes(reinterpret_cast<const char*>(data), std::min(size, fuzz::kMaxBytes));
    config::TrainingPlan plan;
    std::vector<config::ConfigError> errors;
    const bool good = config::parse_training(bytes, "/tmp/fuzz", plan, errors);
    ZONED_ASSERT(good == errors.empty(), "a training file is good, or its mistakes are named");
    fuzz::try_policy(bytes);
    fuzz::try_network(bytes);
    fuzz::try_checkpoint(bytes);
    return 0;
}
