// build: hot loops
#include "server/ai/learning/neural_network.h"

#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>

namespace zoned::ai::learning {

NeuralNetwork dense(std::span<const std::size_t> layers, Activation output) {
    ZONED_ASSERT(layers.size() >= 2, "a network has inputs and outputs");
    NeuralNetwork network;
    network.inputs = layers[0];
    std::size_t begin = 0;  // of the layer before, among values
    for (std::size_t layer = 1; layer < layers.size(); ++layer) {
        const std::size_t end = network.values();
        const bool last = layer + 1 == layers.size();
        for (std::size_t n = 0; n < layers[layer]; ++n) {
            const std::size_t value = network.values();
            network.nodes.push_back({static_cast<std::uint32_t>(network.parameters.size()),
                                     static_cast<std::uint32_t>(end - begin),
                                     last ? output : Activation::kSquash});
            network.source.push_back(0);
            for (std::size_t from = begin; from < end; ++from) {
                network.source.push_back(static_cast<std::uint16_t>(from));
            }
            network.parameters.resize(network.source.size(), 0.0F);
            if (last) {
                network.outputs.push_back(static_cast<std::uint16_t>(value));
            }
        }
        begin = end;
    }
    ZONED_ASSERT(defect_of(network).empty(), "a dense network is sound");
    return network;
}

void randomise(NeuralNetwork& network, core::Rng& rng) {
    for (const NeuralNetwork::Neuron& node : network.nodes) {
        const float reach = std::sqrt(6.0F / static_cast<float>(node.links + 1));
        network.parameters[node.first] = 0.0F;
        for (std::uint32_t k = 1; k <= node.links; ++k) {
            network.parameters[node.first + k] = rng.range(-reach, reach);
        }
    }
}

std::string defect_of(const NeuralNetwork& network) {
    if (network.inputs == 0 || network.outputs.empty()) {
        return "it has no inputs or no outputs";
    }
    // Each by itself first: their sum might be beyond all numbers.
    if (network.inputs > kMaxValues || network.nodes.size() > kMaxValues ||
        network.values() > kMaxValues) {
        return "it has more than " + std::to_string(kMaxValues) + " inputs and nodes";
    }
    if (network.outputs.size() > kMaxValues || network.parameters.size() > kMaxLinks) {
        return "it has more than " + std::to_string(kMaxLinks) + " links or too many outputs";
    }
    if (network.source.size() != network.parameters.size()) {
        return "it has " + std::to_string(network.source.size()) + " sources for " +
               std::to_string(network.parameters.size()) + " parameters";
    }
    std::size_t next = 0;
    for (std::size_t n = 0; n < network.nodes.size(); ++n) {
        const NeuralNetwork::Neuron& node = network.nodes[n];
        const std::string name = "node " + std::to_string(n);
        if (node.first != next || node.links >= network.parameters.size() - next) {
            return name + " has parameters that do not exist";
        }
        for (std::size_t k = 1; k <= node.links; ++k) {
            if (network.source[next + k] >= network.inputs + n) {
                return name + " reads value " + std::to_string(network.source[next + k]) +
                       ", which does not come before it";
            }
        }
        next += node.links + 1;
        if (next >= network.parameters.size() && n + 1 < network.nodes.size()) {
            return "node " + std::to_string(n + 1) + " has parameters that do not exist";
        }
    }
    if (next != network.parameters.size()) {
        return "it has parameters that no node uses";
    }
    for (const std::uint16_t output : network.outputs) {
        if (output >= network.values()) {
            return "output " + std::to_string(output) + " is no value of it";
        }
    }
    if (!std::all_of(network.parameters.begin(), network.parameters.end(), [](float p) {
            return std::isfinite(p);
        })) {
        return "a parameter is not finite";
    }
    return {};
}

void evaluate(const NeuralNetwork& network,
              std::span<const float> in,
              std::span<float> values,
              std::span<float> out) {
    ZONED_ASSERT(in.size() == network.inputs && values.size() >= network.values() &&
                     out.size() == network.outputs.size(),
                 "a network has room for its values");
    std::copy(in.begin(), in.end(), values.begin());
    const float* const parameters = network.parameters.data();
    const std::uint16_t* const source = network.source.data();
    float* value = values.data() + network.inputs;
    for (const NeuralNetwork::Neuron& node : network.nodes) {
        float sum = parameters[node.first];
        const std::uint32_t end = node.first + node.links;
        for (std::uint32_t p = node.first + 1; p <= end; ++p) {
            sum += parameters[p] * values[source[p]];
        }
        *value++ = node.activation == Activation::kSquash ? squash(sum) : sum;
    }
    for (std::size_t o = 0; o < out.size(); ++o) {
        out[o] = values[network.outputs[o]];
    }
}

}  // namespace zoned::ai::learning
