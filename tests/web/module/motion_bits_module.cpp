// The exports of the module with which tests compare a browser's build.
#include "tests/web/motion_bits.h"

#include <cstddef>

namespace {

std::vector<float> numbers;

}  // namespace

extern "C" __attribute__((visibility("default"))) std::size_t bits_count(std::size_t subject) {
    numbers = zoned::testing_web::numbers_of(subject);
    return numbers.size();
}

extern "C" __attribute__((visibility("default"))) const float* bits_numbers() {
    return numbers.data();
}
