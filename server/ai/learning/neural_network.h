// NeuralNetwork: a feed-forward network of any topology, flat: evaluated for one or in columns, the
// same bits on every machine.
#pragma once

#include "shared/core/rng.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace zoned::ai::learning {

/// Inputs and nodes of one network.
inline constexpr std::size_t kMaxValues = 1024;
inline constexpr std::size_t kMaxLinks = 65536;

enum class Activation : std::uint8_t {
    kSquash,  ///< squash() of the weighted sum
    kLinear,  ///< the sum itself
};

/// The quotient c (27 + c^2) / (27 + 9 c^2) with c = x within [-3, 3]: the Pade approximant [3/2]
/// of tanh, which meets -1 and 1 with slope 0, so that it is smooth, rises everywhere in between,
/// and lies within 0.0236 of tanh. Only sums, products and one division, which IEEE 754 rounds
/// alike everywhere; a tanh of the C library differs from one to the next. NaN stays NaN.
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
        std::uint32_t first = 0;  ///< parameter that is its bias; the weights of its links follow
        std::uint32_t links = 0;
        Activation activation = Activation::kSquash;

        friend bool operator==(const Neuron&, const Neuron&) = default;
    };

    std::size_t inputs = 0;
    std::vector<Neuron> nodes;
    std::vector<float> parameters;       ///< of all nodes, in their order
    std::vector<std::uint16_t> source;   ///< by parameter: the value that it weighs (bias: unused)
    std::vector<std::uint16_t> outputs;  ///< values

    [[nodiscard]] std::size_t values() const { return inputs + nodes.size(); }

    friend bool operator==(const NeuralNetwork&, const NeuralNetwork&) = default;
};

/// All of a layer to all of the next; `layers` are the numbers of inputs, of nodes of each hidden
/// layer, and of outputs: at least two, each > 0. Parameters are 0.
NeuralNetwork dense(std::span<const std::size_t> layers, Activation output = Activation::kSquash);

/// Weights uniform within sqrt(6 / (links in + 1)) of 0, biases 0, which keeps the spread of sums
/// near 1 (after Glorot, Bengio, "Understanding the difficulty of training deep feedforward neural
/// networks", AISTATS 2010, section 4.2, with the links in alone: a flat network has no layers).
void randomise(NeuralNetwork& network, core::Rng& rng);

/// What is wrong with a network from outside; empty: it can be evaluated.
std::string defect_of(const NeuralNetwork& network);

/// `in`: inputs; `values`: network.values() places, holds all values afterwards; `out`: as many as
/// outputs. Sums begin with the bias and go through the links in their order. Allocates nothing.
void evaluate(const NeuralNetwork& network,
              std::span<const float> in,
              std::span<float> values,
              std::span<float> out);

/// Evaluated side by side by evaluate_many().
inline constexpr std::size_t kLanes = 16;

/// `in` and `out`: a column for each input and output, `count` long; `scratch`: values() * kLanes
/// places. The same bits as evaluate() for each. Allocates nothing.
void evaluate_many(const NeuralNetwork& network,
                   std::span<const float* const> in,
                   std::size_t count,
                   std::span<float> scratch,
                   std::span<float* const> out);

}  // namespace zoned::ai::learning
