// Descent: fits a network to samples by gradients, with the same bits for the same seed.
#pragma once

#include "server/ai/learning/neural_network.h"

#include <cstdint>
#include <span>
#include <vector>

namespace zoned::ai::learning {

/// Pairs of inputs and wanted outputs, one after the other.
struct Samples {
    std::size_t inputs = 0;
    std::size_t outputs = 0;
    std::vector<float> in;   ///< size() x inputs numbers
    std::vector<float> out;  ///< size() x outputs numbers

    [[nodiscard]] std::size_t size() const { return inputs == 0 ? 0 : in.size() / inputs; }

    [[nodiscard]] std::span<const float> in_of(std::size_t sample) const {
        return {&in[sample * inputs], inputs};
    }

    [[nodiscard]] std::span<const float> out_of(std::size_t sample) const {
        return {&out[sample * outputs], outputs};
    }

    void add(std::span<const float> from, std::span<const float> wanted);
};

/// The mean squared difference over samples and outputs.
double mean_squared_error(const NeuralNetwork& network, const Samples& samples);

/// The same for the best constant: the mean of the wanted outputs.
double error_of_best_constant(const Samples& samples);

/// Adds the gradient of the squared difference, summed over outputs, to `gradient` (by parameter)
/// and returns that difference. Source: Rumelhart, Hinton, Williams, "Learning representations by
/// back-propagating errors", Nature 323, 1986. `values`, `sums` and `blame` are working memory of
/// network.values() places.
float add_gradient(const NeuralNetwork& network,
                   std::span<const float> in,
                   std::span<const float> wanted,
                   std::span<float> values,
                   std::span<float> sums,
                   std::span<float> blame,
                   std::span<float> gradient);

struct DescentSettings {
    float step = 0.003F;     ///< > 0
    std::size_t batch = 32;  ///< samples in a step, > 0
};

/// Adam with its defaults except the step. Source: Kingma, Ba, "Adam: a method for stochastic
/// optimization", ICLR 2015, algorithm 1.
class Descent {
  public:
    /// The state to continue from, together with the network and the settings: a copy resumes bit
    /// for bit.
    struct DescentState {
        std::vector<float> mean;    ///< mean of the gradients, by parameter
        std::vector<float> square;  ///< mean of their squares
        double mean_decay = 1.0;    ///< products of the decays so far
        double square_decay = 1.0;
        core::Rng rng;  ///< shuffles samples

        friend bool operator==(const DescentState& a, const DescentState& b) {
            return a.mean == b.mean && a.square == b.square && a.mean_decay == b.mean_decay &&
                   a.square_decay == b.square_decay && a.rng.state == b.rng.state &&
                   a.rng.stream == b.rng.stream;
        }
    };

    Descent(const DescentSettings& settings, const NeuralNetwork& network, std::uint64_t seed);

    /// Trains on every sample once, in a newly drawn order. Returns the mean squared error during
    /// the epoch.
    double epoch(NeuralNetwork& network, const Samples& samples);

    [[nodiscard]] const DescentState& state() const { return state_; }

    /// `state` must come from a network with as many parameters.
    void restore(DescentState state);

  private:
    void step(NeuralNetwork& network, std::size_t samples);

    DescentSettings settings_;
    DescentState state_;
    std::vector<std::uint32_t> order_;
    std::vector<float> values_, sums_, blame_, gradient_;
};

}  // namespace zoned::ai::learning
