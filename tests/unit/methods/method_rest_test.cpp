// All methods through Scene::step: what stands stays, what slides slides.
#include "tests/unit/methods/method_scene.h"

namespace zoned::physics {
namespace {

TEST(Methods, HoldAStackOfFiveBoxesForFiveSeconds) {
    for (const Method method : all_methods()) {
        MethodScene s(settings_of(method, 30));
        s.ground();
        for (int i = 0; i < 5; ++i) {
            s.box(Vec3(0.0F, 0.5F + static_cast<float>(i), 0.0F));
        }
        s.run(5.0F);
        for (std::size_t i = 0; i < 5; ++i) {
            const BodyState state = s.scene.state(s.bodies[i]);
            printf("%s %zu y %g v %g x %g z %g\n", name_of(method).c_str(), i, state.position.y()-0.5-i, state.velocity.norm(), state.position.x(), state.position.z());
        }
    }
}

}  // namespace
}  // namespace zoned::physics
