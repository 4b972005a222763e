#include "server/ai/learning/genome.h"

#include "server/ai/learning/genetic.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>

namespace zoned::ai::learning {

namespace {

bool has(const std::vector<std::uint32_t>& ascending, std::uint32_t id) {
    return std::binary_search(ascending.begin(), ascending.end(), id);
}

bool has_link(const Genome& genome, std::uint32_t from, std::uint32_t to) {
    return std::any_of(genome.links.begin(), genome.links.end(), [from, to](const auto& link) {
        return link.from == from && link.to == to;
    });
}

void insert(Genome& genome, const Genome::GeneLink& link) {
    const auto at = std::lower_bound(
        genome.links.begin(), genome.links.end(), link, [](const auto& a, const auto& b) {
            return a.innovation < b.innovation;
        });
    ZONED_ASSERT(at == genome.links.end() || at->innovation != link.innovation,
                 "a genome has a link once");
    genome.links.insert(at, link);
}

/// Nodes that lead to an output by links that are on, in an order in which each comes after all
/// that it reads; outputs are always among them.
std::vector<std::uint32_t> order_of(const Genome& genome) {
    std::vector<std::uint32_t> wanted;
    for (std::uint32_t o = 0; o < genome.outputs; ++o) {
        wanted.push_back(genome.first_output() + o);
    }
    for (std::size_t k = 0; k < wanted.size(); ++k) {
        for (const Genome::GeneLink& link : genome.links) {
            const bool inner = link.from >= genome.first_output();
            if (link.on && inner && link.to == wanted[k] &&
                std::find(wanted.begin(), wanted.end(), link.from) == wanted.end()) {
                wanted.push_back(link.from);
            }
        }
    }
    std::sort(wanted.begin(), wanted.end());
    std::vector<std::uint32_t> order;
    const auto waits = [&genome, &wanted, &order](std::uint32_t node) {
        return std::any_of(genome.links.begin(), genome.links.end(), [&](const auto& link) {
            return link.on && link.to == node && has(wanted, link.from) &&
                   std::find(order.begin(), order.end(), link.from) == order.end();
        });
    };
    while (order.size() < wanted.size()) {
        const std::size_t before = order.size();
        for (const std::uint32_t node : wanted) {
            if (std::find(order.begin(), order.end(), node) == order.end() && !waits(node)) {
                order.push_back(node);
            }
        }
        ZONED_ASSERT(order.size() > before, "links of a genome close no circle");
    }
    return order;
}

}  // namespace

std::uint32_t Inventions::link(std::uint32_t from, std::uint32_t to) {
    return links.try_emplace({from, to}, static_cast<std::uint32_t>(links.size())).first->second;
}

std::uint32_t Inventions::node(const Genome& genome, std::uint32_t innovation) {
    std::vector<std::uint32_t>& known = nodes[innovation];
    for (const std::uint32_t id : known) {
        if (!has(genome.hidden, id)) {
            return id;
        }
    }
    known.push_back(next_node++);
    return known.back();
}

Genome simplest(std::uint32_t inputs, std::uint32_t outputs, Inventions& inventions) {
    Genome genome;
    genome.inputs = inputs;
    genome.outputs = outputs;
    inventions.next_node = std::max(inventions.next_node, genome.first_hidden());
    for (std::uint32_t o = 0; o < outputs; ++o) {
        const std::uint32_t to = genome.first_output() + o;
        for (std::uint32_t from = 0; from <= genome.bias(); ++from) {
            insert(genome, {inventions.link(from, to), from, to, 0.0F, true});
        }
    }
    return genome;
}

NeuralNetwork network_of(const Genome& genome) {
    const std::vector<std::uint32_t> order = order_of(genome);
    const auto value_of = [&genome, &order](std::uint32_t node) {
        const auto at = std::find(order.begin(), order.end(), node) - order.begin();
        return static_cast<std::uint16_t>(
            node < genome.inputs ? node : genome.inputs + static_cast<std::size_t>(at));
    };
    NeuralNetwork network;
    network.inputs = genome.inputs;
    for (const std::uint32_t node : order) {
        const auto first = static_cast<std::uint32_t>(network.parameters.size());
        network.parameters.push_back(0.0F);
        network.source.push_back(0);
        for (const Genome::GeneLink& link : genome.links) {
            if (!link.on || link.to != node) {
                continue;
            }
            if (link.from == genome.bias()) {
                network.parameters[first] += link.weight;
            } else {
                network.parameters.push_back(link.weight);
                network.source.push_back(value_of(link.from));
            }
        }
        const auto links = static_cast<std::uint32_t>(network.parameters.size() - first - 1);
        network.nodes.push_back({first, links, Activation::kSquash});
    }
    for (std::uint32_t o = 0; o < genome.outputs; ++o) {
        network.outputs.push_back(value_of(genome.first_output() + o));
    }
    return network;
}

bool closes_circle(const Genome& genome, std::uint32_t from, std::uint32_t to) {
    std::vector<std::uint32_t> reached{to};
    for (std::size_t k = 0; k < reached.size(); ++k) {
        if (reached[k] == from) {
            return true;
        }
        for (const Genome::GeneLink& link : genome.links) {
            if (link.from == reached[k] &&
                std::find(reached.begin(), reached.end(), link.to) == reached.end()) {
                reached.push_back(link.to);
            }
        }
    }
    return false;
}

float distance_of(const Genome& a, const Genome& b, const Distance& distance) {
    const auto last = [](const Genome& g) {
        return g.links.empty() ? 0U : g.links.back().innovation;
    };
    const std::uint32_t end = std::min(last(a), last(b));
    std::size_t disjoint = 0;
    std::size_t excess = 0;
    std::size_t both = 0;
    float difference = 0.0F;
    const auto alone = [&](const Genome::GeneLink& link) {
        ++(link.innovation > end ? excess : disjoint);
    };
    auto in_a = a.links.begin();
    auto in_b = b.links.begin();
    while (in_a != a.links.end() || in_b != b.links.end()) {
        if (in_b == b.links.end() ||
            (in_a != a.links.end() && in_a->innovation < in_b->innovation)) {
            alone(*in_a++);
        } else if (in_a == a.links.end() || in_b->innovation < in_a->innovation) {
            alone(*in_b++);
        } else {
            difference += std::abs(in_a++->weight - in_b++->weight);
            ++both;
        }
    }
    const std::size_t larger = std::max(a.links.size(), b.links.size());
    const float genes = larger < 20 ? 1.0F : static_cast<float>(larger);
    const float mean = both == 0 ? 0.0F : difference / static_cast<float>(both);
    return (distance.excess * static_cast<float>(excess) +
            distance.disjoint * static_cast<float>(disjoint)) /
               genes +
           distance.weight * mean;
}

Genome cross(const Genome& fitter, const Genome& other, core::Rng& rng) {
    Genome child = fitter;
    auto from = other.links.begin();
    for (Genome::GeneLink& link : child.links) {
        while (from != other.links.end() && from->innovation < link.innovation) {
            ++from;
        }
        if (from == other.links.end() || from->innovation != link.innovation) {
            continue;
        }
        const bool off = !link.on || !from->on;
        if ((rng.next() & 1U) != 0) {
            link.weight = from->weight;
        }
        link.on = !off || rng.below(4) == 0;
    }
    return child;
}

bool add_link(Genome& genome, Inventions& inventions, core::Rng& rng) {
    const auto hidden = static_cast<std::uint32_t>(genome.hidden.size());
    const std::uint32_t sources = genome.inputs + 1 + hidden;
    const std::uint32_t targets = genome.outputs + hidden;
    constexpr int kAttempts = 20;
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
        const std::uint32_t s = rng.below(sources);
        const std::uint32_t t = rng.below(targets);
        const std::uint32_t from = s <= genome.bias() ? s : genome.hidden[s - genome.inputs - 1];
        const std::uint32_t to =
            t < genome.outputs ? genome.first_output() + t : genome.hidden[t - genome.outputs];
        if (has_link(genome, from, to) || closes_circle(genome, from, to)) {
            continue;
        }
        insert(genome, {inventions.link(from, to), from, to, rng.range(-1.0F, 1.0F), true});
        return true;
    }
    return false;
}

bool add_node(Genome& genome, Inventions& inventions, core::Rng& rng) {
    std::vector<std::size_t> on;
    for (std::size_t k = 0; k < genome.links.size(); ++k) {
        if (genome.links[k].on) {
            on.push_back(k);
        }
    }
    if (on.empty() || genome.first_hidden() + genome.hidden.size() + 1 >= kMaxValues) {
        return false;
    }
    Genome::GeneLink& split = genome.links[on[rng.below(static_cast<std::uint32_t>(on.size()))]];
    split.on = false;
    const Genome::GeneLink old = split;
    const std::uint32_t node = inventions.node(genome, old.innovation);
    genome.hidden.insert(std::upper_bound(genome.hidden.begin(), genome.hidden.end(), node), node);
    insert(genome, {inventions.link(old.from, node), old.from, node, 1.0F, true});
    insert(genome, {inventions.link(node, old.to), node, old.to, old.weight, true});
    return true;
}

}  // namespace zoned::ai::learning
