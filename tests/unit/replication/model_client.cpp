#include "tests/unit/replication/model_client.h"

namespace zoned::replication {

void ModelClient::receive(std::uint64_t sequence, std::span<const std::uint8_t> body) {
    const auto parsed = wire::read_down_head(body);
    if (!parsed) {
        ++malformed;
        return;
    }
    const wire::DownHead& down = parsed->head;
    const auto records = body.subspan(parsed->records_offset);
    std::shared_ptr<const wire::record::RecordFrame> frame;
    if (down.coded) {
        const auto decoded = coded_.decode(
            static_cast<wire::entropy::PacketNumber>(sequence), down.tick, down.zone, records);
        if (!decoded) {
            ++undecoded;
            return;
        }
        frame = *decoded;
    }
    if (!acks.on_received(sequence)) {
        return;
    }
    ++packets;
    newest_tick = std::max(newest_tick, down.tick);
    if (down.has_own && sequence > own_sequence_) {
        own_sequence_ = sequence;
        own = down.own;
    }
    if (frame != nullptr) {
        ++coded_packets;
        read_coded(sequence, *frame);
    } else {
        read_records(sequence, down, records);
    }
}

void ModelClient::read_records(std::uint64_t sequence,
                               const wire::DownHead& down,
                               std::span<const std::uint8_t> records) {
    wire::RecordReader reader(records, quantization_);
    while (!reader.done()) {
        const auto head = reader.next_head();
        if (!head) {
            ++malformed;
            return;
        }
        if (head->kind != wire::RecordKind::kRemove) {
            read_state(*head, sequence, down, reader);
        } else {
            remove(head->entity, sequence);
        }
        std::uint64_t& mentioned = mentioned_[head->entity];
        mentioned = std::max(mentioned, sequence);
    }
}

void ModelClient::read_coded(std::uint64_t sequence, const wire::record::RecordFrame& frame) {
    for (const wire::record::CodedRecord& record : frame.records) {
        std::uint64_t& mentioned = mentioned_[record.entity];
        if (record.remove) {
            remove(record.entity, sequence);
        } else if (record.type >= types_->size() ||
                   record.upright != (*types_)[record.type].upright()) {
            ++malformed;
        } else if (sequence > mentioned) {
            Known next;
            next.zone = frame.zone;
            next.lod = record.lod;
            next.type = record.type;
            next.upright = record.upright;
            next.tick = record.tick;
            next.state = record.state;
            next.from =
                wire::dequantize(next.state, next.upright, wire::at_lod(quantization_, next.lod));
            known[record.entity] = next;
        }
        mentioned = std::max(mentioned, sequence);
    }
}

void ModelClient::remove(EntityId entity, std::uint64_t sequence) {
    if (sequence <= mentioned_[entity]) {
        return;
    }
    known.erase(entity);
    removed_[entity] = sequence;
    std::erase_if(keyframes_,
                  [&](const auto& entry) { return std::get<0>(entry.first) == entity; });
}

void ModelClient::read_state(const wire::RecordHead& head,
                             std::uint64_t sequence,
                             const wire::DownHead& down,
                             wire::RecordReader& reader) {
    const bool is_update = sequence > mentioned_[head.entity];
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
        if (it == keyframes_.end() || !is_update) {
            undecodable += is_update ? 1 : 0;
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
    if (is_update) {
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
