// Genome: a network that can grow, with the history by which two of them are compared.
#pragma once

#include "server/ai/learning/neural_network.h"

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

namespace zoned::ai::learning {

/// Nodes are numbered: inputs, then one that is always 1 (the bias), outputs, hidden ones. Links
/// never close a circle, those that are off included.
struct Genome {
    struct GeneLink {
        std::uint32_t innovation = 0;  ///< historical marking: the same for the same invention
        std::uint32_t from = 0;
        std::uint32_t to = 0;
        float weight = 0.0F;
        bool on = true;

        friend bool operator==(const GeneLink&, const GeneLink&) = default;
    };

    std::uint32_t inputs = 0;
    std::uint32_t outputs = 0;
    std::vector<GeneLink> links;        ///< ascending by innovation
    std::vector<std::uint32_t> hidden;  ///< nodes, ascending

    [[nodiscard]] std::uint32_t bias() const { return inputs; }

    [[nodiscard]] std::uint32_t first_output() const { return inputs + 1; }

    [[nodiscard]] std::uint32_t first_hidden() const { return inputs + 1 + outputs; }

    friend bool operator==(const Genome&, const Genome&) = default;
};

/// Who invented what, over a whole run: the same link, or the same node in the middle of the same
/// link, has the same number in all genomes. (Stanley, Miikkulainen, "Evolving neural networks
/// through augmenting topologies", Evolutionary Computation 10, 2002, section 3.2; there the list
/// is kept for one generation, which gives the same invention another number later.)
struct Inventions {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> links;  ///< by from and to
    /// Nodes in the middle of a link, by its innovation: more than one where a genome has split it
    /// again after another switched it back on.
    std::map<std::uint32_t, std::vector<std::uint32_t>> nodes;
    std::uint32_t next_node = 0;

    std::uint32_t link(std::uint32_t from, std::uint32_t to);
    /// A node in the middle of the link that `genome` has not yet.
    std::uint32_t node(const Genome& genome, std::uint32_t innovation);
};

/// Every input and the bias to every output, weights 0.
Genome simplest(std::uint32_t inputs, std::uint32_t outputs, Inventions& inventions);

/// The genome as a network: what leads to no output is left out. Parameters are sums in the order
/// of innovations, so that equal genomes give equal bits.
NeuralNetwork network_of(const Genome& genome);

/// True where a link from one to the other would close a circle.
bool closes_circle(const Genome& genome, std::uint32_t from, std::uint32_t to);

struct Distance {
    float excess = 1.0F;    ///< weight of genes beyond the other's last, and of
    float disjoint = 1.0F;  ///< those between, each per gene of the larger genome (of 20 and more)
    float weight = 0.4F;    ///< of the mean difference of weights that both have
};

/// How foreign two genomes are to each other (section 3.3, equation 1).
float distance_of(const Genome& a, const Genome& b, const Distance& distance);

/// A child: links that both have come from either, the others as `fitter` has them, so its links
/// and nodes are those of `fitter` (section 3.2, figure 4; where both are equally fit the caller
/// says which). What is off in a parent is off in the child with probability 3 in 4.
Genome cross(const Genome& fitter, const Genome& other, core::Rng& rng);

/// Each changes one thing; false where there is nothing to change.
bool add_link(Genome& genome, Inventions& inventions, core::Rng& rng);
/// Splits a link: it is off, one of weight 1 leads to the new node, one of its own weight on from
/// it (section 3.1).
bool add_node(Genome& genome, Inventions& inventions, core::Rng& rng);

}  // namespace zoned::ai::learning
