#include "server/admin/spectator/spectator_layers.h"

#include "server/world/entities.h"

#include <utility>

namespace zoned::admin {

namespace {

std::string layer_head(std::uint32_t kind, const SpectatorSample& sample, std::size_t count) {
    std::string out;
    put_bytes(out, kind);
    put_bytes(out, static_cast<std::uint32_t>(sample.tick));
    put_bytes(out, static_cast<std::uint32_t>(count));
    put_bytes(out, std::uint32_t{0});
    return out;
}

void put_place(std::string& out, const Vec3d& at) {
    for (int axis = 0; axis < 3; ++axis) {
        put_bytes(out, static_cast<float>(at[axis]));
    }
}

SpectatorMessage shared(std::string text) {
    return std::make_shared<const std::string>(std::move(text));
}

SpectatorMessage joints_of(const SpectatorSample& sample) {
    std::string out = layer_head(3, sample, sample.joints.size());
    for (const SpectatorJoint& joint : sample.joints) {
        for (const Vec3d& point : joint) {
            put_place(out, point);
        }
    }
    return shared(std::move(out));
}

SpectatorMessage particles_of(const SpectatorSample& sample) {
    std::string out = layer_head(5, sample, sample.particles.size());
    for (const auto& at : sample.particles) {
        put_bytes(out, at);
    }
    return shared(std::move(out));
}

SpectatorMessage moved_of(const SpectatorSample& sample) {
    std::string out = layer_head(7, sample, sample.moved_doors.size());
    for (const std::uint32_t door : sample.moved_doors) {
        put_bytes(out, door);
    }
    for (const Tick along : sample.moved_platforms) {
        put_bytes(out, static_cast<std::int32_t>(along));
    }
    return shared(std::move(out));
}

SpectatorMessage ghosts_of(const SpectatorSample& sample) {
    std::string rows;
    std::size_t count = 0;
    for (const SpectatorZone& zone : sample.zones) {
        for (std::size_t row = 0; row < zone.id.size(); ++row) {
            if ((zone.flags[row] & world::kGhost) != 0) {
                put_place(rows, zone.origin + zone.position[row].cast<double>());
                put_bytes(rows,
                          static_cast<std::uint32_t>(zone.type[row]) +
                              (static_cast<std::uint32_t>(zone.number) << 16U));
                ++count;
            }
        }
    }
    return shared(layer_head(6, sample, count) + rows);
}

}  // namespace

static_assert(sizeof(physics::soft::SoftVertex) == 36, "vertices are sent as they lie");

SpectatorMessage SpectatorLayers::softs(const SpectatorSample& sample, bool whole) {
    std::string out = layer_head(4, sample, sample.softs.size());
    if (surfaces_.size() > 2 * sample.softs.size()) {
        surfaces_.clear();  // most of them are of bodies that are gone
    }
    for (const SpectatorSoft& soft : sample.softs) {
        SentSurface& sent = surfaces_[soft.entity];
        const bool same = sent.faces == soft.faces && sent.hung == soft.hung;
        if (!same) {
            sent = {soft.faces, soft.hung};
        }
        const bool sends = whole || !same;
        put_bytes(out, soft.entity.value);
        put_bytes(out, static_cast<std::uint32_t>(soft.nodes.size()));
        put_bytes(out, static_cast<std::uint32_t>(sends ? soft.faces.size() : 0));
        put_bytes(out, static_cast<std::uint32_t>(sends ? soft.hung.size() : 0));
        for (const Vec3& node : soft.nodes) {
            put_place(out, soft.origin + node.cast<double>());
        }
        if (sends) {
            for (const auto& face : soft.faces) {
                put_bytes(out, face);
            }
            for (const auto& vertex : soft.hung) {
                put_bytes(out, vertex);
            }
        }
    }
    return shared(std::move(out));
}

std::vector<SpectatorLayers::Message> SpectatorLayers::update(const SpectatorSample& sample,
                                                              bool whole) {
    std::vector<Message> out;
    if ((sample.layers & kLayerJoints) != 0) {
        out.push_back({kLayerJoints, joints_of(sample)});
    }
    if ((sample.layers & kLayerSofts) != 0) {
        out.push_back({kLayerSofts, softs(sample, whole)});
    }
    if ((sample.layers & kLayerParticles) != 0) {
        out.push_back({kLayerParticles, particles_of(sample)});
    }
    if ((sample.layers & kLayerGhosts) != 0) {
        out.push_back({kLayerGhosts, ghosts_of(sample)});
    }
    if ((sample.layers & kLayerMoved) != 0) {
        out.push_back({kLayerMoved, moved_of(sample)});
    }
    return out;
}

}  // namespace zoned::admin
