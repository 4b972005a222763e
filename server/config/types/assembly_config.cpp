#include "server/config/types/assembly_config.h"

#include "server/config/settings.h"
#include "server/config/text/check_name.h"
#include "server/config/text/config_numbers.h"
#include "server/config/types/joint_config.h"
#include "server/config/types/part_overlaps.h"
#include "server/config/types/type_shapes.h"
#include "server/physics/shapes/compound/bounds.h"
#include "server/zone/simulation/type_body.h"
#include "proto/config/config.pb.h"

#include <algorithm>
#include <set>
#include <string>
#include <vector>

namespace zoned::config {

namespace {

using proto::config::Assembly;
using proto::config::BodyPart;
using proto::config::Config;
using proto::config::Type;

/// Parts included.
constexpr int kMostTypes = 10000;

template <class List>
int index_in(const List& list, const std::string& name) {
    for (int i = 0; i < list.size(); ++i) {
        if (list[i].name() == name) {
            return i;
        }
    }
    return -1;
}

/// Shape, mass and material of a part.
void give_part(const BodyPart& part, Type& type) {
    switch (part.shape_case()) {
        case BodyPart::kBox:
            *type.mutable_box() = part.box();
            break;
        case BodyPart::kSphere:
            *type.mutable_sphere() = part.sphere();
            break;
        case BodyPart::kCapsule:
            *type.mutable_capsule() = part.capsule();
            break;
        case BodyPart::kHull:
            *type.mutable_hull() = part.hull();
            break;
        case BodyPart::kCompound:
            *type.mutable_compound() = part.compound();
            break;
        case BodyPart::SHAPE_NOT_SET:
            break;
    }
    type.set_mass_kg(part.mass_kg());
    if (part.has_friction()) {
        type.set_friction(part.friction());
    }
    if (part.has_restitution()) {
        type.set_restitution(part.restitution());
    }
    if (!part.replicated()) {
        type.clear_aura_m();
    }
}

/// False where parts cannot be made of it.
bool check_whole(const Type& type, const std::string& path, Diagnostics& diagnostics) {
    const std::size_t before = diagnostics.size();
    if (type.kind() != proto::config::PROP) {
        diagnostics.add(path + ".assembly", "belongs to props only");
    }
    if (type.shape_case() != Type::SHAPE_NOT_SET) {
        diagnostics.add(path, "takes one of a shape and assembly { ... }");
    }
    if (type.has_mass_kg()) {
        diagnostics.add(path + ".mass_kg", "each part of an assembly has its own");
    }
    if (type.has_inertia()) {
        diagnostics.add(path + ".inertia", "each part of an assembly has that of its shape");
    }
    if (type.has_representation()) {
        diagnostics.add(path + ".representation", "a part of an assembly is what it is");
    }
    std::set<std::string> names;
    for (int p = 0; p < type.assembly().part_size(); ++p) {
        const BodyPart& part = type.assembly().part(p);
        const std::string here = join_path(path + ".assembly", "part", p);
        if (check_name(part.name(), "part", here, diagnostics) &&
            !names.insert(part.name()).second) {
            diagnostics.add(here + ".name", "'" + part.name() + "' is the name of another part");
        }
        if (part.shape_case() == BodyPart::SHAPE_NOT_SET) {
            diagnostics.add(here, "a part needs a shape: box, sphere, capsule, hull or compound");
        }
    }
    if (type.assembly().part_size() == 0) {
        diagnostics.add(path + ".assembly", "needs a part { ... }");
    }
    return diagnostics.size() == before;
}

/// A part's body where it is put together, m, in the assembly's axes.
struct PlacedPart {
    Vec3d centre = Vec3d::Zero();
    Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
    Quat stands = Quat::Identity();  ///< of the shape alone
};

PlacedPart place_part(const BodyPart& part, const Type& type) {
    PlacedPart out;
    const Eigen::Quaterniond turned = turn(part.yaw_deg(), part.pitch_deg(), part.roll_deg());
    Vec3d centre = Vec3d::Zero();
    if (part.has_hull() || part.has_compound()) {
        const auto solid = build_solid(type);
        if (solid) {  // else check_types says why
            centre = solid->centre.cast<double>();
            out.stands = solid->stands;
        }
    }
    out.centre = Vec3d(part.x_m(), part.y_m(), part.z_m()) + turned * centre;
    out.orientation = turned * out.stands.cast<double>();
    return out;
}

/// Expands one assembly.
class AssemblyReader {
  public:
    AssemblyReader(const Config& config, int type, Settings& settings, Diagnostics& diagnostics)
        : config_(config),
          type_(type),
          from_(config.type(type).assembly()),
          path_(join_path("", "type", type) + ".assembly"),
          settings_(settings),
          diagnostics_(diagnostics) {}

    zone::AssemblyDef read(std::uint16_t number) {
        const std::size_t before = diagnostics_.size();
        read_parts(number);
        for (int j = 0; j < from_.joint_size(); ++j) {
            read_one_joint(from_.joint(j), join_path(path_, "joint", j));
        }
        // A joint with a mistake holds nothing and has no motor: no need to say so too.
        if (diagnostics_.size() == before) {
            report_loose_parts();
            report_overlaps();
            read_seats();
            read_controls();
        }
        return std::move(out_);
    }

  private:
    [[nodiscard]] int type_of(int part) const {
        const std::string& name = config_.type(type_).name();
        return part == 0 ? type_ : index_in(config_.type(), name + "." + from_.part(part).name());
    }

    void read_parts(std::uint16_t number) {
        for (int p = 0; p < from_.part_size(); ++p) {
            placed_.push_back(place_part(from_.part(p), config_.type(type_of(p))));
        }
        const PlacedPart& root = placed_.front();
        Aabb whole;
        for (int p = 0; p < from_.part_size(); ++p) {
            const PlacedPart& part = placed_[static_cast<std::size_t>(p)];
            const int index = type_of(p);
            world::EntityType& type = settings_.types[static_cast<std::size_t>(index)];
            type.assembly = static_cast<std::uint16_t>(number + 1);
            type.part = static_cast<std::uint16_t>(p);
            const Eigen::Quaterniond back = root.orientation.conjugate();
            out_.parts.push_back({from_.part(p).name(),
                                  static_cast<TypeIndex>(index),
                                  (back * (part.centre - root.centre)).cast<float>(),
                                  narrow(back * part.orientation)});
            const physics::Shape shape = zone::body_of(type, settings_.solids).shape;
            const Aabb box =
                physics::shape_bounds(shape,
                                      (part.centre - root.centre).cast<float>(),
                                      part.orientation.toRotationMatrix().cast<float>());
            whole = p == 0 ? box
                           : Aabb{whole.lower.cwiseMin(box.lower), whole.upper.cwiseMax(box.upper)};
        }
        world::EntityType& of_root = settings_.types[static_cast<std::size_t>(type_)];
        of_root.stands = narrow(root.orientation);
        of_root.standing = whole;
    }

    /// Number of a part; reports a name that none has.
    int part_named(const std::string& name, const std::string& at) {
        const int part = index_in(from_.part(), name);
        if (part < 0) {
            diagnostics_.add(at,
                             name.empty() ? "a joint needs the name of a part"
                                          : "there is no part named '" + name + "'");
        }
        return part;
    }

    void read_one_joint(const proto::config::Joint& from, const std::string& here) {
        if (from.has_name()) {
            if (check_name(from.name(), "joint", here, diagnostics_) &&
                !names_.insert(from.name()).second) {
                diagnostics_.add(here + ".name",
                                 "'" + from.name() + "' is the name of another joint");
            }
        }
        const int b = part_named(from.b(), here + ".b");
        const int a = from.has_a() ? part_named(from.a(), here + ".a") : -1;
        held_.insert({a, b});
        if (b < 0 || (a < 0 && from.has_a())) {
            return;
        }
        if (a == b) {
            diagnostics_.add(here + ".b", "a part cannot be joined to itself");
            return;
        }
        JointEnds ends;
        ends.to_world = a < 0;
        ends.stands_b = placed_[static_cast<std::size_t>(b)].stands;
        if (a >= 0) {
            ends.stands_a = placed_[static_cast<std::size_t>(a)].stands;
        }
        if (auto plan = read_joint(from, ends, here, diagnostics_)) {
            const std::uint16_t end = a < 0 ? zone::kWorldPart : static_cast<std::uint16_t>(a);
            out_.joints.push_back({std::move(plan), end, static_cast<std::uint16_t>(b)});
        }
    }

    void report_loose_parts() {
        for (int p = 0; p < from_.part_size(); ++p) {
            if (held_.count(p) == 0 && from_.part_size() > 1) {
                diagnostics_.add(join_path(path_, "part", p), "no joint holds it");
            }
        }
    }

    void report_overlaps() {
        for (const PartOverlap& one : part_overlaps(out_, settings_.types, settings_.solids)) {
            diagnostics_.add(join_path(path_, "part", static_cast<int>(one.b)),
                             "overlaps part '" + out_.parts[one.a].name + "' by " +
                                 text_of("%.2g m", static_cast<double>(one.depth_m)) +
                                 ", and no joint between them keeps them from colliding");
        }
    }

    void read_seats() {
        for (int s = 0; s < from_.seat_size(); ++s) {
            const proto::config::Seat& seat = from_.seat(s);
            const int part = seat.has_part()
                                 ? part_named(seat.part(), join_path(path_, "seat", s) + ".part")
                                 : 0;
            if (part >= 0) {
                const Vec3 place(narrow(seat.place().x_m()),
                                 narrow(seat.place().y_m()),
                                 narrow(seat.place().z_m()));
                out_.seats.push_back(
                    {static_cast<std::uint16_t>(part),
                     placed_[static_cast<std::size_t>(part)].stands.conjugate() * place});
            }
        }
    }

    void read_controls() {
        for (int c = 0; c < from_.control_size(); ++c) {
            const proto::config::Control& control = from_.control(c);
            const std::string here = join_path(path_, "control", c) + ".joint";
            const auto at = std::find_if(
                out_.joints.begin(), out_.joints.end(), [&](const zone::AssemblyJoint& joint) {
                    return joint.plan->name == control.joint() && !control.joint().empty();
                });
            if (at == out_.joints.end()) {
                diagnostics_.add(here, "there is no joint named '" + control.joint() + "'");
            } else if (!at->plan->motor) {
                diagnostics_.add(here, "joint '" + control.joint() + "' has no motor");
            } else {
                const bool angle = at->plan->motor->holds_position &&
                                   at->plan->def.kind == physics::JointKind::kHinge;
                out_.controls.push_back({static_cast<std::uint16_t>(at - out_.joints.begin()),
                                         control.input() == proto::config::Control::SIDE,
                                         narrow(control.value() * (angle ? kRadians : 1.0))});
            }
        }
        if (from_.control_size() > 0 && from_.seat_size() == 0) {
            diagnostics_.add(join_path(path_, "control", 0), "nobody drives it: it has no seat");
        }
    }

    const Config& config_;
    int type_;
    const Assembly& from_;
    std::string path_;
    Settings& settings_;
    Diagnostics& diagnostics_;
    std::vector<PlacedPart> placed_;
    std::set<std::string> names_;
    std::set<int> held_;
    zone::AssemblyDef out_;
};

}  // namespace

void make_part_types(Config& config, Diagnostics& diagnostics) {
    const int written = config.type_size();
    for (int t = 0; t < written; ++t) {
        const std::string path = join_path("", "type", t);
        if (!config.type(t).has_assembly()) {
            continue;
        }
        if (!check_whole(config.type(t), path, diagnostics)) {
            diagnostics.silence_line_of(path);
            config.mutable_type(t)->clear_assembly();
            continue;
        }
        const Type whole = config.type(t);
        for (int p = 0; p < whole.assembly().part_size(); ++p) {
            const BodyPart& part = whole.assembly().part(p);
            const std::string here = join_path(path + ".assembly", "part", p);
            if (p == 0) {
                give_part(part, *config.mutable_type(t));
                for (const char* shape : {".hull", ".compound"}) {
                    diagnostics.set_origin(path + shape, here + shape, "");
                }
                continue;
            }
            if (config.type_size() >= kMostTypes) {
                diagnostics.add(here, "more than 10000 types and parts in all");
                return;
            }
            diagnostics.set_origin(join_path("", "type", config.type_size()),
                                   here,
                                   "type '" + whole.name() + "." + part.name() + "'");
            Type& made = *config.add_type();
            made = whole;
            made.clear_assembly();
            made.clear_field();  // the root has them
            made.set_name(whole.name() + "." + part.name());
            give_part(part, made);
        }
    }
}

void expand_assemblies(const Config& config, Settings& settings, Diagnostics& diagnostics) {
    auto table = std::make_shared<zone::AssemblyTable>();
    for (int t = 0; t < config.type_size(); ++t) {
        if (config.type(t).has_assembly()) {
            table->push_back(AssemblyReader(config, t, settings, diagnostics)
                                 .read(static_cast<std::uint16_t>(table->size())));
        }
    }
    settings.assemblies = std::move(table);
}

}  // namespace zoned::config
