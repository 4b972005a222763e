#include "tests/fuzz/wire_seeds.h"

#include "tests/fuzz/fuzz.h"

namespace zoned::fuzz {

std::vector<Bytes> seeds() {
    core::Rng rng(1);
    std::vector<Bytes> all;
    for (int i = 0; i < 64; ++i) {
        all.push_back(wire::fuzz::valid_input(rng));
    }
    return all;
}

}  // namespace zoned::fuzz
