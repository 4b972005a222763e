// How soft bodies are saved and loaded. Working memory of a step is left out.
#include "server/physics/soft/soft_impl.h"
#include "shared/core/archive/field_archive.h"

#include <algorithm>
#include <string>

namespace zoned::physics::soft {

template <class Archive>
void serialize(Archive& archive, SoftBody& body) {
    archive(body.x, body.v, body.start, body.kept, body.predicted, body.mass, body.springs);
    archive(body.batches, body.faces, body.tetrahedra, body.rest_volume, body.vertices);
    archive(body.drawn_faces,
            body.surface,
            body.gas,
            body.material,
            body.solver,
            body.user,
            body.contacts);
    archive(body.neighbours, body.close_pairs, body.linked, body.substeps_done, body.box);
    archive(body.still_s, body.there, body.asleep, body.rigid, body.touches_dynamic, body.torn);
    archive(body.limit.longest_step_s);
}

namespace {

/// Whether all numbers name nodes that there are.
bool is_sound(const SoftBody& body) {
    const std::size_t nodes = body.x.size();
    const auto here = [nodes](std::uint32_t node) {
        return node < nodes;
    };
    const auto all_here = [&](const auto& several) {
        return std::all_of(several.begin(), several.end(), here);
    };
    bool sound = body.v.size() == nodes && body.start.size() == nodes &&
                 body.mass.size() == nodes && body.rest_volume.size() == body.tetrahedra.size() &&
                 body.solver.method <= SoftMethod::kSemiImplicitEuler &&
                 body.solver.substeps <= kMostSubsteps && all_here(body.surface);
    for (const Spring& spring : body.springs) {
        sound = sound && here(spring.a) && here(spring.b);
    }
    for (const SoftFace& face : body.faces) {
        sound = sound && all_here(face);
    }
    for (const SoftTetrahedron& tetrahedron : body.tetrahedra) {
        sound = sound && all_here(tetrahedron);
    }
    for (const SoftVertex& vertex : body.vertices) {
        sound = sound && all_here(vertex.node);
    }
    for (const SoftFace& face : body.drawn_faces) {
        sound = sound && std::all_of(face.begin(), face.end(), [&](std::uint32_t vertex) {
                    return vertex < body.vertices.size();
                });
    }
    for (const auto& pair : body.close_pairs) {
        sound = sound && all_here(pair);
    }
    for (const NodeContact& contact : body.contacts) {
        sound = sound && here(contact.node);
    }
    return sound;
}

}  // namespace

template <class Archive>
void SoftBodies::serialize(Archive& archive) {
    archive(retired_);
    bool any = impl_ != nullptr;
    archive(any);
    if (!any) {
        if constexpr (Archive::kReads) {
            impl_.reset();
        }
        return;
    }
    if constexpr (Archive::kReads) {
        impl_ = std::make_unique<Impl>();
    }
    archive(impl_->bodies);
    if constexpr (Archive::kReads) {
        if (!std::all_of(impl_->bodies.begin(), impl_->bodies.end(), is_sound)) {
            archive.fail("a soft body names nodes that it has not");
            return;
        }
        std::for_each(impl_->bodies.begin(), impl_->bodies.end(), find_skin);
    }
}

void SoftBodies::save(core::FieldWriter& archive) const {
    const_cast<SoftBodies&>(*this).serialize(archive);  // writing leaves it as it is
}

void SoftBodies::load(core::FieldReader& archive) {
    serialize(archive);
}

}  // namespace zoned::physics::soft
