// NeuralNetwork: a flat feed-forward network of any topology, with the same bits on every computer.
#pragma once

#include "shared/core/rng.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace zoned::ai::learning {

/// The most inputs and nodes of one network.
inline constexpr std::size_t kMaxValues = 1024;
inline constexpr std::size_t kMaxLinks = 65536;

enum class Activation : std::uint8_t {
    kSquash,  ///< squash() of the weighted sum
    kLinear,  ///< the sum itself
};

/// The quotient c (27 + c^2) / (27 + 9 c^2) with c = x within [-3, 3]: the Pade approximant [3/2]
/// of tanh. It meets -1 and 1 with slope 0, so it is smooth. It rises everywhere in between and
/// lies within 0.0236 of tanh. It takes only sums, products and one division, which IEEE 754 rounds
/// alike everywhere; tanh differs between C libraries. NaN stays NaN.
inline float squash(float x) {
    const float high = x > 3.0F ? 3.0F : x;
    const float c = high < -3.0F ? -3.0F : high;
    const float s = c * c;
    return c * (27.0F + s) / (27.0F + 9.0F * s);
}

/// Its derivative: ((9 - c^2) / (9 + 3 c^2))^2.
inline float squash_slope(float x) {
    const float high = x > 3.0F ? 3.0F : x;
    const float c = high < -3.0F ? -3.0F : high;
    const float s = c * c;
    const float root = (9.0F - s) / (9.0F + 3.0F * s);
    return root * root;
}

/// Values are numbered: inputs, then nodes as they stand. A node reads only values before it.
struct NeuralNetwork {
    struct Neuron {
        std::uint32_t first = 0;  ///< the index of its bias parameter; the weights of its links
                                  ///< follow
        std::uint32_t links = 0;
        Activation activation = Activation::kSquash;

        friend bool operator==(const Neuron&, const Neuron&) = default;
    };

    std::size_t inputs = 0;
    std::vector<Neuron> nodes;
    std::vector<float> parameters;       ///< parameters of all nodes, in their order
    std::vector<std::uint16_t> source;   ///< by parameter: the value that it weighs (unused for a
                                         ///< bias)
    std::vector<std::uint16_t> outputs;  ///< values

    [[nodiscard]] std::size_t values() const { return inputs + nodes.size(); }

    friend bool operator==(const NeuralNetwork&, const NeuralNetwork&) = default;
};

/// Links each layer fully to the next. `layers` are the numbers of inputs, of nodes of each hidden
/// layer, and of outputs: at least two numbers, each > 0. All parameters are 0.
NeuralNetwork dense(std::span<const std::size_t> layers, Activation output = Activation::kSquash);

/// Draws weights uniform within sqrt(6 / (links in + 1)) of 0, and sets biases to 0. This keeps the
/// spread of sums near 1. Source: Glorot, Bengio, "Understanding the difficulty of training deep
/// feedforward neural networks", AISTATS 2010, section 4.2. Only the links in count here, because a
/// flat network has no layers.
void randomise(NeuralNetwork& network, core::Rng& rng);

/// The defect of a network from outside; empty: it can be evaluated.
std::string defect_of(const NeuralNetwork& network);

/// `in`: inputs. `values`: network.values() places, holds all values afterwards. `out`: as many as
/// outputs. Sums begin with the bias and go through the links in their order. Allocates nothing.
void evaluate(const NeuralNetwork& network,
              std::span<const float> in,
              std::span<float> values,
              std::span<float> out);

}  // namespace zoned::ai::learning
