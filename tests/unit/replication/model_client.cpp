#include "tests/unit/replication/model_client.h"

namespace zoned::replication {

void ModelClient::receive(std::uint64_t sequence, std::span<const std::uint8_t> body) {
    if (!acks.on_received(sequence)) {
        return;
    }
    ++packets;
    const auto parsed = wire::read_down_head(body);
    if (!parsed) {
        ++malformed;
        return;
    }
    const wire::DownHead& down = parsed->head;
    newest_tick = std::max(newest_tick, down.tick);
    if (down.has_own && sequence > own_sequence_) {
        own_sequence_ = sequence;
        own = down.own;
    }
    wire::RecordReader reader(body.subspan(parsed->records_offset), quantization_);
    while (!reader.done()) {
        const auto head = reader.next_head();
        if (!head) {
            ++malformed;
            return;
        }
        std::uint64_t& mentioned = mentioned_[head->entity];
        if (head->kind != wire::RecordKind::kRemove) {
            read_state(*head, sequence, down, reader);
        } else if (sequence > mentioned) {
            known.erase(head->entity);
            removed_[head->entity] = sequence;
            std::erase_if(keyframes_, [&](const auto& entry) {
                return std::get<0>(entry.first) == head->entity;
            });
        }
        mentioned = std::max(mentioned, sequence);
    }
}

void ModelClient::read_state(const wire::RecordHead& head,
                             std::uint64_t sequence,
                             const wire::DownHead& down,
                             wire::RecordReader& reader) {
    const bool is_news = sequence > mentioned_[head.entity];
    const bool is_alive = sequence > removed_[head.entity];
    const KeyframeKey key{head.entity, down.zone, head.lod, head.keyframe};
    Known next;
    next.zone = down.zone;
    next.lod = head.lod;
    next.tick = wire::expand_tick(head.tick_low, down.tick);
    if (head.kind == wire::RecordKind::kAbsolute) {
        if (head.type >= types_->size()) {
            ++malformed;
            return;
        }
        next.type = head.type;
        next.upright = (*types_)[head.type].upright();
        const auto state = reader.read_absolute(next.upright);
        if (!state) {
            ++malformed;
            return;
        }
        next.state = *state;
        Keyframe& keyframe = keyframes_[key];
        if (is_alive && sequence > keyframe.sequence) {
            keyframe = {sequence, *state, head.type};
        }
    } else {
        const auto it = keyframes_.find(key);
        if (it == keyframes_.end() || !is_news) {
            undecodable += is_news ? 1 : 0;
            malformed += reader.skip_delta(head.upright) ? 0 : 1;
            return;
        }
        next.type = it->second.type;
        next.upright = (*types_)[next.type].upright();
        const auto state = reader.read_delta(it->second.state, next.upright);
        if (!state) {
            ++malformed;
            return;
        }
        next.state = *state;
    }
    if (is_news) {
        next.from =
            wire::dequantize(next.state, next.upright, wire::at_lod(quantization_, next.lod));
        known[head.entity] = next;
    }
}

motion::KinematicState ModelClient::predict(const Known& k, Tick now) const {
    return motion::predict(k.from, k.state.order, static_cast<float>(now - k.tick) * tick_s_);
}

void ModelClient::forget() {
    known.clear();
    keyframes_.clear();
    own.reset();
}

}  // namespace zoned::replication
