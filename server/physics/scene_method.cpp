// The solve of a step by an alternative to ContactSolver.
#include "server/physics/methods/method_stepper.h"
#include "server/physics/scene_impl.h"

namespace zoned::physics {

Scene::Impl::~Impl() = default;

void Scene::Impl::solve_by_method(float dt) {
    stepper->solve({bodies, graph, solve_list, joints, active_joints, settings, dt}, broken);
    substeps = static_cast<std::uint32_t>(stepper->substeps());
}

const RowSystem* Scene::problem() const {
    return impl_->stepper && impl_->settings.methods.keep_problem ? &impl_->stepper->problem()
                                                                  : nullptr;
}

}  // namespace zoned::physics
