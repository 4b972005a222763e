#include "client-sim/audit/auditor.h"

#include <algorithm>
#include <iterator>

namespace zoned::audit {

namespace {

/// The truth of a frozen world as the level of detail of `shown` writes it. The server's own
/// integers are those of the nearest level.
wire::QuantizedState resting(const view::WorldInfo& world,
                             const view::Version& shown,
                             const wire::AuditEntityMessage& truth) {
    const view::ZoneInfo* zone = world.zone(shown.zone);
    const Vec3d place(truth.position[0], truth.position[1], truth.position[2]);
    motion::KinematicState state;
    state.position = (place - (zone != nullptr ? zone->origin : Vec3d(0, 0, 0))).cast<float>();
    state.orientation = Quat(
        truth.orientation[0], truth.orientation[1], truth.orientation[2], truth.orientation[3]);
    const auto appearance =
        static_cast<std::uint16_t>(truth.quantized.size() == 8 ? truth.quantized[7] : 0);
    return wire::quantize(state,
                          motion::PredictorOrder::kStatic,
                          world.types[truth.type].upright,
                          true,
                          appearance,
                          wire::at_lod(world.quantization, shown.lod));
}

}  // namespace

void Auditor::compare_frozen(const view::View& view,
                             EntityId avatar,
                             const wire::AuditRecordMessage& record) {
    frozen_.seen = true;
    frozen_.converged = false;
    const view::EntityStore& store = view.store();
    std::size_t listed_present = 0;
    for (const wire::AuditEntityMessage& truth : record.entities) {
        const EntityId id(truth.entity);
        const view::Entity* entity = store.find(id);
        const bool present = entity != nullptr && entity->present();
        const std::string name =
            "entity " + std::to_string(id.value) + " (" + view.world().types[truth.type].name + ")";
        if (id == avatar) {
            continue;
        }
        if (!present) {
            if (truth.must_know) {
                frozen_.difference = name + " is not in the view";
                return;
            }
            continue;
        }
        ++listed_present;
        const view::Version& shown = entity->versions.back();
        const wire::QuantizedState& s = shown.quantized;
        const bool coarser = view.world().quantization.lod_shift[shown.lod] != wire::LodShift{};
        const std::int32_t mine[8] = {s.position[0],
                                      s.position[1],
                                      s.position[2],
                                      s.orientation_largest,
                                      s.orientation[0],
                                      s.orientation[1],
                                      s.orientation[2],
                                      s.appearance};
        const bool same = truth.quantized.size() == 8 && shown.zone.value == record.zone &&
                          std::equal(std::begin(mine), std::end(mine), truth.quantized.begin());
        if (coarser ? !(shown.zone.value == record.zone && s == resting(view.world(), shown, truth))
                    : !same) {
            frozen_.difference = name + " differs from the server's quantised state";
            return;
        }
        const auto fields = view::EntityStore::fields_at(*entity, record.tick);
        if (!std::equal(
                fields.begin(), fields.end(), truth.field_words.begin(), truth.field_words.end())) {
            frozen_.difference = name + " has other declared fields than the server's";
            return;
        }
    }
    // A client hears of its own avatar among the others for its declared fields alone.
    const view::Entity* own = store.find(avatar);
    const bool listed = own != nullptr && own->present() &&
                        wire::schema_of(view.world().fields, own->type) != nullptr;
    listed_present += listed ? 1 : 0;
    if (listed_present != store.present_count()) {
        frozen_.difference = std::to_string(store.present_count() - listed_present) +
                             " entities are in the view that the server does not list";
        return;
    }
    frozen_.converged = true;
    frozen_.difference.clear();
}

}  // namespace zoned::audit
