// Fuzz: the interface of each fuzzing target, for libFuzzer and for the plain driver alike.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

/// Runs the target once on an input of any bytes; aborts when a promise is broken. (libFuzzer's
/// interface, https://llvm.org/docs/LibFuzzer.html.)
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace zoned::fuzz {

using Bytes = std::vector<std::uint8_t>;

/// Valid inputs of the target to begin with.
std::vector<Bytes> seeds();

/// Cuts an input into actions: a byte for the kind, two bytes of length, and as many bytes (or as
/// many as are left).
class Actions {
  public:
    explicit Actions(std::span<const std::uint8_t> input) : rest_(input) {}

    /// False at the end.
    bool next(std::uint8_t& what, std::span<const std::uint8_t>& bytes) {
        if (rest_.size() < 3) {
            return false;
        }
        what = rest_[0];
        const std::size_t length = rest_[1] | static_cast<std::size_t>(rest_[2]) << 8U;
        rest_ = rest_.subspan(3);
        bytes = rest_.first(std::min(length, rest_.size()));
        rest_ = rest_.subspan(bytes.size());
        return true;
    }

    /// Appends an action to a seed.
    static void add(std::uint8_t what, std::span<const std::uint8_t> bytes, Bytes& out) {
        out.push_back(what);
        out.push_back(static_cast<std::uint8_t>(bytes.size() & 0xFFU));
        out.push_back(static_cast<std::uint8_t>(bytes.size() >> 8U));
        out.insert(out.end(), bytes.begin(), bytes.end());
    }

    static void add(std::uint8_t what, const std::string& bytes, Bytes& out) {
        add(what, {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}, out);
    }

  private:
    std::span<const std::uint8_t> rest_;
};

}  // namespace zoned::fuzz
