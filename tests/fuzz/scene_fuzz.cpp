// Fuzzing of scene files: any bytes are refused with a reason, or give a scene that runs and comes
// back from its own text.
#include "tests/fuzz/fuzz.h"
#include "tests/stability/random/scene_generator.h"
#include "tests/stability/random/scene_run.h"
#include "tests/stability/random/scene_text.h"

#include <algorithm>

namespace zoned::fuzz {

namespace {

constexpr std::size_t kMostBytes = 65536;
constexpr std::size_t kMostRunBodies = 64;

void run(std::string_view bytes) {
    const auto scene = stability::scene_from_text(bytes);
    if (!scene) {
        ZONED_ASSERT(!scene.error().empty(), "a refusal has a reason");
        return;
    }
    const std::string text = stability::scene_to_text(*scene);
    const auto again = stability::scene_from_text(text);
    ZONED_ASSERT(again.ok(), "what was read can be written and read back");
    ZONED_ASSERT(stability::scene_to_text(*again) == text, "and is the same");
    stability::RandomScene brief = *scene;
    brief.seconds = std::min(brief.seconds, 3.0F * brief.dt);
    if (brief.bodies.size() <= kMostRunBodies && brief.joints.size() <= kMostRunBodies) {
        stability::run_scene(brief);
    }
}

}  // namespace

std::vector<Bytes> seeds() {
    std::vector<Bytes> all;
    for (std::uint64_t k = 0; k < 12; ++k) {
        const std::string text = stability::scene_to_text(stability::generate_scene(1, k));
        all.emplace_back(text.begin(), text.end());
    }
    return all;
}

}  // namespace zoned::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace zoned;
    fuzz::run({reinterpret_cast<const char*>(data), std::min(size, fuzz::kMostBytes)});
    return 0;
}
