#include "server/config/text/sha256.h"
#include "server/config/training/policy_file.h"
#include "server/config/training/training_file.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <utility>

namespace zoned::config {

namespace {

namespace learning = ai::learning;
using proto::TrainingCheckpoint;
using EvolutionResult = core::Result<learning::Evolution::EvolutionState>;
using DescentResult = core::Result<learning::Descent::DescentState>;
using CheckpointResult = core::Result<TrainingCheckpoint>;

constexpr std::string_view kMagic = "zonedtr1";
constexpr std::size_t kDigestChars = 64;
constexpr std::uint64_t kMostCheckpointBytes = 1ULL << 31U;

void fill(const core::Rng& rng, TrainingCheckpoint& out) {
    out.set_rng_state(rng.state);
    out.set_rng_stream(rng.stream);
}

core::Rng rng_of(const TrainingCheckpoint& message) {
    core::Rng rng;
    rng.state = message.rng_state();
    rng.stream = message.rng_stream() | 1U;
    return rng;
}

void fill(const std::vector<float>& genes, TrainingCheckpoint::Genes& out) {
    out.mutable_gene()->Add(genes.begin(), genes.end());
}

std::vector<float> genes_of(const TrainingCheckpoint::Genes& message) {
    return {message.gene().begin(), message.gene().end()};
}

void fill(const learning::Genome& genome, TrainingCheckpoint::Genome& out) {
    out.set_inputs(genome.inputs);
    out.set_outputs(genome.outputs);
    for (const learning::Genome::GeneLink& link : genome.links) {
        TrainingCheckpoint::Link& to = *out.add_link();
        to.set_innovation(link.innovation);
        to.set_from(link.from);
        to.set_to(link.to);
        to.set_weight(link.weight);
        to.set_on(link.on);
    }
    out.mutable_hidden()->Add(genome.hidden.begin(), genome.hidden.end());
}

/// False for a genome that no training makes: ids out of order or unknown, cycles, NaN.
bool read_genome(const TrainingCheckpoint::Genome& message,
                 std::size_t inputs,
                 std::size_t outputs,
                 learning::Genome& genome) {
    genome.inputs = message.inputs();
    genome.outputs = message.outputs();
    if (genome.inputs != inputs || genome.outputs != outputs ||
        message.hidden_size() > static_cast<int>(learning::kMaxValues) ||
        message.link_size() > static_cast<int>(learning::kMaxLinks)) {
        return false;
    }
    genome.hidden.assign(message.hidden().begin(), message.hidden().end());
    for (std::size_t k = 0; k < genome.hidden.size(); ++k) {
        if (genome.hidden[k] < genome.first_hidden() ||
            (k > 0 && genome.hidden[k] <= genome.hidden[k - 1])) {
            return false;
        }
    }
    const auto known = [&genome](std::uint32_t node) {
        return node < genome.first_hidden() ||
               std::binary_search(genome.hidden.begin(), genome.hidden.end(), node);
    };
    for (const TrainingCheckpoint::Link& link : message.link()) {
        const bool ascends =
            genome.links.empty() || link.innovation() > genome.links.back().innovation;
        if (!ascends || !known(link.from()) || !known(link.to()) ||
            link.to() < genome.first_output() || !std::isfinite(link.weight()) ||
            closes_circle(genome, link.from(), link.to())) {
            return false;
        }
        genome.links.push_back(
            {link.innovation(), link.from(), link.to(), link.weight(), link.on()});
    }
    return true;
}

void fill(const learning::Neat::NeatState& neat, TrainingCheckpoint& out) {
    out.set_round(neat.generation);
    fill(neat.rng, out);
    for (const learning::Genome& genome : neat.genomes) {
        fill(genome, *out.add_genome());
    }
    for (const learning::Neat::Species& species : neat.species) {
        TrainingCheckpoint::Species& to = *out.add_species();
        fill(species.representative, *to.mutable_representative());
        to.set_best(species.best);
        to.set_improved_at(species.improved_at);
        to.mutable_member()->Add(species.members.begin(), species.members.end());
    }
    for (const auto& [ends, innovation] : neat.inventions.links) {
        auto& to = *out.add_link_invention();
        to.set_from(ends.first);
        to.set_to(ends.second);
        to.set_innovation(innovation);
    }
    for (const auto& [innovation, nodes] : neat.inventions.nodes) {
        auto& to = *out.add_node_invention();
        to.set_innovation(innovation);
        to.mutable_node()->Add(nodes.begin(), nodes.end());
    }
    out.set_next_node(neat.inventions.next_node);
}

/// False where the same number stands for two inventions, or a genome has a part without an
/// invention: it would grow into one that has a link twice.
bool read_inventions(const TrainingCheckpoint& message, learning::Neat::NeatState& neat) {
    learning::Inventions& inventions = neat.inventions;
    inventions.next_node = message.next_node();
    const std::uint32_t first_hidden = neat.genomes.front().first_hidden();
    const auto links = static_cast<std::uint32_t>(message.link_invention_size());
    std::vector<bool> numbered(links, false);
    for (const auto& from : message.link_invention()) {
        if (from.innovation() >= links || numbered[from.innovation()] ||
            from.from() >= inventions.next_node || from.to() >= inventions.next_node ||
            !inventions.links.try_emplace({from.from(), from.to()}, from.innovation()).second) {
            return false;
        }
        numbered[from.innovation()] = true;
    }
    std::set<std::uint32_t> named;
    for (const auto& from : message.node_invention()) {
        for (const std::uint32_t node : from.node()) {
            if (node < first_hidden || node >= inventions.next_node || !named.insert(node).second) {
                return false;
            }
        }
        inventions.nodes[from.innovation()].assign(from.node().begin(), from.node().end());
    }
    const auto invented = [&inventions, &named](const learning::Genome& genome) {
        return std::all_of(genome.links.begin(),
                           genome.links.end(),
                           [&inventions](const learning::Genome::GeneLink& link) {
                               const auto at = inventions.links.find({link.from, link.to});
                               return at != inventions.links.end() && at->second == link.innovation;
                           }) &&
               std::all_of(genome.hidden.begin(),
                           genome.hidden.end(),
                           [&named](std::uint32_t node) { return named.count(node) != 0; });
    };
    return inventions.next_node >= first_hidden &&
           std::all_of(neat.genomes.begin(), neat.genomes.end(), invented);
}

bool read_neat(const TrainingCheckpoint& message,
               const learning::NeatSettings& settings,
               std::size_t inputs,
               std::size_t outputs,
               learning::Neat::NeatState& neat) {
    neat.generation = message.round();
    neat.rng = rng_of(message);
    if (message.genome_size() != static_cast<int>(settings.population) ||
        message.species_size() == 0) {
        return false;
    }
    for (const auto& from : message.genome()) {
        if (!read_genome(from, inputs, outputs, neat.genomes.emplace_back())) {
            return false;
        }
    }
    for (const auto& from : message.species()) {
        learning::Neat::Species& species = neat.species.emplace_back();
        species.best = from.best();
        species.improved_at = from.improved_at();
        species.members.assign(from.member().begin(), from.member().end());
        const bool sound =
            !species.members.empty() &&
            std::all_of(species.members.begin(), species.members.end(), [&neat](std::uint32_t m) {
                return m < neat.genomes.size();
            });
        if (!sound || species.improved_at > neat.generation ||
            !read_genome(from.representative(), inputs, outputs, species.representative)) {
            return false;
        }
    }
    return read_inventions(message, neat);
}

std::string reason_of_errno() {
    return errno != 0 ? std::strerror(errno) : "unknown reason";
}

}  // namespace

void fill(const learning::Evolution::EvolutionState& state, TrainingCheckpoint& out) {
    *out.mutable_best() = message_of(state.best);
    out.set_score(state.score);
    out.set_fitness(state.fitness);
    if (const auto* genetic = std::get_if<learning::Genetic::GeneticState>(&state.population)) {
        out.set_round(genetic->generation);
        fill(genetic->rng, out);
        for (const std::vector<float>& genes : genetic->genes) {
            fill(genes, *out.add_individual());
        }
    } else {
        fill(std::get<learning::Neat::NeatState>(state.population), out);
    }
}

void fill(const learning::Descent::DescentState& state, TrainingCheckpoint& out) {
    fill(state.rng, out);
    fill(state.mean, *out.mutable_mean());
    fill(state.square, *out.mutable_square());
    out.set_mean_decay(state.mean_decay);
    out.set_square_decay(state.square_decay);
}

EvolutionResult evolution_state(const TrainingCheckpoint& message,
                                const learning::BreedingSettings& settings,
                                std::size_t inputs,
                                std::size_t outputs) {
    learning::Evolution::EvolutionState state;
    auto best = network_of(message.best());
    if (!best) {
        return EvolutionResult::failure(best.error());
    }
    state.best = std::move(*best);
    state.score = message.score();
    state.fitness = message.fitness();
    if (state.best.inputs != inputs || state.best.outputs.size() != outputs) {
        return EvolutionResult::failure("its best network is of another task");
    }
    if (const auto* neat = std::get_if<learning::NeatSettings>(&settings)) {
        learning::Neat::NeatState population;
        if (!read_neat(message, *neat, inputs, outputs, population)) {
            return EvolutionResult::failure("its genomes are no population of this training");
        }
        state.population = std::move(population);
        return state;
    }
    const auto& fixed = std::get<learning::FixedTopology>(settings);
    learning::Genetic::GeneticState population;
    population.generation = message.round();
    population.rng = rng_of(message);
    for (const auto& individual : message.individual()) {
        population.genes.push_back(genes_of(individual));
        if (population.genes.back().size() != fixed.shape.parameters.size()) {
            return EvolutionResult::failure("an individual has another number of weights");
        }
    }
    if (population.genes.size() != fixed.genetic.population) {
        return EvolutionResult::failure("its population has another size");
    }
    state.population = std::move(population);
    return state;
}

DescentResult descent_state(const TrainingCheckpoint& message, std::size_t parameters) {
    learning::Descent::DescentState state;
    state.mean = genes_of(message.mean());
    state.square = genes_of(message.square());
    state.mean_decay = message.mean_decay();
    state.square_decay = message.square_decay();
    state.rng = rng_of(message);
    if (state.mean.size() != parameters || state.square.size() != parameters) {
        return DescentResult::failure("it is of a network with another number of weights");
    }
    return state;
}

core::Result<bool> write_whole(const std::string& file, const std::string& bytes) {
    using Written = core::Result<bool>;
    const std::string unfinished = file + ".unfinished";
    errno = 0;
    {
        std::ofstream out(unfinished, std::ios::binary | std::ios::trunc);
        out << bytes;
        out.flush();
        if (!out.good()) {
            return Written::failure("cannot write " + unfinished + ": " + reason_of_errno());
        }
    }
    std::error_code error;
    std::filesystem::rename(unfinished, file, error);
    if (error) {
        return Written::failure("cannot write " + file + ": " + error.message());
    }
    return true;
}

core::Result<bool> write_checkpoint(const std::string& file, const TrainingCheckpoint& checkpoint) {
    const std::string payload = checkpoint.SerializeAsString();
    return write_whole(file, std::string(kMagic) + sha256_hex(payload) + payload);
}

CheckpointResult read_checkpoint(const std::string& file) {
    std::error_code error;
    const std::uint64_t size = std::filesystem::file_size(file, error);
    std::ifstream in(file, std::ios::binary);
    if (error || !in.good()) {
        return CheckpointResult::failure(file + ": cannot be read");
    }
    if (size > kMostCheckpointBytes) {
        return CheckpointResult::failure(file + ": is no checkpoint of a training");
    }
    std::ostringstream text;
    text << in.rdbuf();
    const std::string bytes = text.str();
    const std::size_t head = kMagic.size() + kDigestChars;
    if (bytes.size() < head || bytes.compare(0, kMagic.size(), kMagic) != 0) {
        return CheckpointResult::failure(file + ": is no checkpoint of a training");
    }
    const std::string payload = bytes.substr(head);
    TrainingCheckpoint checkpoint;
    if (bytes.compare(kMagic.size(), kDigestChars, sha256_hex(payload)) != 0 ||
        !checkpoint.ParseFromString(payload)) {
        return CheckpointResult::failure(file + ": is damaged");
    }
    return checkpoint;
}

}  // namespace zoned::config
