#include "server/physics/joints/joint_table.h"

namespace zoned::physics {

JointId JointTable::id_of(std::uint32_t index) const {
    return JointId((static_cast<std::uint32_t>(entries_[index].generation) << 20) | (index + 1));
}

std::uint32_t JointTable::index_of(JointId id) const {
    const std::uint32_t number = id.value & 0xFFFFFU;
    if (number == 0 || number > rows()) {
        return kNoIndex;
    }
    const JointEntry& entry = entries_[number - 1];
    return entry.alive && entry.generation == (id.value >> 20) ? number - 1 : kNoIndex;
}

JointId JointTable::add(Bodies& bodies, const Joint& joint, std::uint32_t a, std::uint32_t b) {
    std::uint32_t index = rows();
    if (!free_.empty()) {
        index = free_.back();
        free_.pop_back();
        const std::uint16_t generation = entries_[index].generation;
        entries_[index] = JointEntry();
        entries_[index].generation = generation;
    } else {
        entries_.emplace_back();
        free_.reserve(entries_.capacity());
    }
    JointEntry& entry = entries_[index];
    entry.joint = joint;
    entry.a = a;
    entry.b = b;
    entry.alive = true;
    ++size_;
    for (const std::uint32_t side : {0U, 1U}) {
        const std::uint32_t row = side == 0 ? a : b;
        if (row != kNoIndex) {
            entry.next[side] = bodies.first_joint[row];
            bodies.first_joint[row] = index * 2 + side;
        }
    }
    return id_of(index);
}

void JointTable::unlink(Bodies& bodies,
                        std::uint32_t index,
                        std::uint32_t side,
                        std::uint32_t row) {
    const std::uint32_t wanted = index * 2 + side;
    std::uint32_t* link = &bodies.first_joint[row];
    while (*link != wanted) {
        link = &entries_[*link >> 1].next[*link & 1];
    }
    *link = entries_[index].next[side];
}

void JointTable::remove(Bodies& bodies, std::uint32_t index) {
    JointEntry& entry = entries_[index];
    if (entry.a != kNoIndex) {
        unlink(bodies, index, 0, entry.a);
    }
    if (entry.b != kNoIndex) {
        unlink(bodies, index, 1, entry.b);
    }
    entry.alive = false;
    entry.generation = static_cast<std::uint16_t>((entry.generation + 1U) & 0xFFFU);
    free_.push_back(index);
    --size_;
}

bool JointTable::parts(const Bodies& bodies, std::uint32_t a, std::uint32_t b) const {
    bool parted = false;
    for_each_of(bodies, a, [&](std::uint32_t index, std::uint32_t other) {
        parted |= other == b && !entries_[index].joint.def.collide;
    });
    return parted;
}

bool JointTable::is_sound(const Bodies& bodies) const {
    const auto linked = [this](std::uint32_t link) {
        return link == kNoIndex || (link >> 1) < entries_.size();
    };
    const auto row = [&](std::uint32_t index) {
        return index == kNoIndex || index < bodies.rows();
    };
    bool sound = size_ <= entries_.size();
    for (const JointEntry& entry : entries_) {
        sound = sound && row(entry.a) && row(entry.b) && linked(entry.next[0]) &&
                linked(entry.next[1]) && entry.joint.def.kind <= JointKind::kSpring &&
                (!entry.alive || entry.b != kNoIndex);
    }
    for (const std::uint32_t index : free_) {
        sound = sound && index < entries_.size();
    }
    return sound;
}

}  // namespace zoned::physics
