// Genome: a network that can grow, with the history by which two genomes are compared.
#pragma once

#include "server/ai/learning/neural_network.h"

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

namespace zoned::ai::learning {

/// Nodes are numbered: inputs, then one that is always 1 (the bias), outputs, hidden ones. Links
/// never close a circle; this includes links that are off.
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

/// Inventions: the numbers of all inventions of a run. The same link has the same number in all
/// genomes, and so has the same node in the middle of the same link. Source: Stanley, Miikkulainen,
/// "Evolving neural networks through augmenting topologies", Evolutionary Computation 10, 2002,
/// section 3.2. The paper keeps the list for one generation only, so the same invention gets
/// another number later.
struct Inventions {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> links;  ///< by from and to
    /// Nodes in the middle of a link, by the link's innovation. There are several where a genome
    /// split a link again after another genome switched it back on.
    std::map<std::uint32_t, std::vector<std::uint32_t>> nodes;
    std::uint32_t next_node = 0;

    std::uint32_t link(std::uint32_t from, std::uint32_t to);
    /// A node in the middle of the link that `genome` does not have yet.
    std::uint32_t node(const Genome& genome, std::uint32_t innovation);
};

/// Links every input and the bias to every output, with weights 0.
Genome simplest(std::uint32_t inputs, std::uint32_t outputs, Inventions& inventions);

/// The genome as a network. Nodes that lead to no output are left out. Sums go in the order of
/// innovations, so that equal genomes give equal bits.
NeuralNetwork network_of(const Genome& genome);

/// True where a link from `from` to `to` would close a circle.
bool closes_circle(const Genome& genome, std::uint32_t from, std::uint32_t to);

struct Distance {
    float excess = 1.0F;    ///< weight of the genes beyond the other genome's last
    float disjoint = 1.0F;  ///< weight of the genes in between; both per gene of the larger genome
                            ///< (of 20 and more)
    float weight = 0.4F;    ///< weight of the mean difference of shared weights
};

/// The distance between two genomes (section 3.3, equation 1).
float distance_of(const Genome& a, const Genome& b, const Distance& distance);

/// A child of two parents. Links in both parents come from either; all others are as in `fitter`,
/// so its links and nodes are those of `fitter` (section 3.2, figure 4). The caller chooses
/// `fitter` between equally fit parents. A link that is off in a parent is off in the child with
/// probability 3 in 4.
Genome cross(const Genome& fitter, const Genome& other, core::Rng& rng);

/// Each of these changes one thing; false where there is nothing to change.
bool add_link(Genome& genome, Inventions& inventions, core::Rng& rng);
/// Splits a link, which is switched off. A link of weight 1 leads to the new node, and one of the
/// old weight leads on from it (section 3.1).
bool add_node(Genome& genome, Inventions& inventions, core::Rng& rng);

}  // namespace zoned::ai::learning
