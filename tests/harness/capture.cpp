#include "tests/harness/capture.h"

#include "tests/harness/transport_tap.h"
#include "proto/session.pb.h"
#include "shared/wire/publication.h"

#include <algorithm>
#include <utility>

namespace zoned::harness {

namespace {

void read_records(Capture& c, const link::OpenedPacket& packet) {
    wire::RecordReader reader(packet.records, c.quantization);
    while (!reader.done()) {
        const auto head = reader.next_head();
        if (!head) {
            ++c.undecoded;
            return;
        }
        c.records.push_back(
            {packet.head.tick, head->entity, head->kind == wire::RecordKind::kRemove});
        if (head->kind == wire::RecordKind::kRemove) {
            continue;
        }
        if (head->declared) {
            ++c.undecoded;  // captures are of worlds without declared fields
            return;
        }
        bool good = false;
        if (head->kind == wire::RecordKind::kAbsolute) {
            c.type_of[head->entity] = head->type;
            good =
                head->type < c.upright.size() && reader.read_absolute(c.upright[head->type]).ok();
        } else {
            // A delta may refer to a keyframe whose packet was doubled or came late. Its entity's
            // type was sent before in any case.
            const auto type = c.type_of.find(head->entity);
            good = type != c.type_of.end() && reader.skip_delta(c.upright[type->second]).ok();
        }
        if (!good) {
            ++c.undecoded;
            return;
        }
    }
}

void read_coded(Capture& c, const link::OpenedPacket& packet) {
    if (!c.coded) {
        c.coded.emplace(wire::record::RecordFormat(c.quantization, c.tick_s));
    }
    ++c.coded_packets;
    const auto frame = c.coded->decode(static_cast<wire::entropy::PacketNumber>(packet.sequence),
                                       packet.head.tick,
                                       packet.head.zone,
                                       packet.records);
    if (!frame) {
        ++(packet.sequence < c.newest_decoded ? c.overtaken : c.undecoded);
        return;
    }
    c.newest_decoded = std::max(c.newest_decoded, packet.sequence);
    for (const wire::record::CodedRecord& record : (*frame)->records) {
        c.records.push_back({packet.head.tick, record.entity, record.remove});
    }
}

void read_datagram(Capture& c, const std::uint8_t* bytes, std::size_t size) {
    if (!c.client) {
        return;  // it came before Welcome: the client cannot read it either
    }
    const std::uint64_t replayed = c.channel.stats().replayed;
    const auto packet = c.channel.open({bytes, size}, c.now_s);
    if (packet) {
        ++c.packets;
        if (packet->head.coded) {
            read_coded(c, *packet);
        } else {
            read_records(c, *packet);
        }
    } else if (c.channel.stats().replayed == replayed) {
        ++c.undecoded;
    }
}

void read_frame(Capture& c, const link::Bytes& frame) {
    proto::ServerMessage message;
    if (!message.ParseFromArray(frame.data(), static_cast<int>(frame.size()))) {
        ++c.undecoded;
        return;
    }
    if (message.has_welcome()) {
        c.client = ClientId(message.welcome().client_id());
        c.channel.set_connection(message.welcome().connection_id());
        c.channel.rekey(wire::SealKey::from(message.welcome().datagram_key_down()).value(),
                        wire::SealKey::from(message.welcome().datagram_key_up()).value());
        if (!message.welcome().resumed()) {
            c.channel.restart();
            c.coded.reset();
            c.newest_decoded = 0;
        }
    } else if (message.has_event()) {
        const proto::Event& event = message.event();
        c.events.push_back(
            {event.tick(), event.event_id(), event.kind(), event.topic(), event.payload()});
    } else if (message.has_datagram()) {
        const std::string& sealed = message.datagram().sealed();
        read_datagram(c, reinterpret_cast<const std::uint8_t*>(sealed.data()), sealed.size());
    }
}

class CaptureTransport final : public TransportTap {
  public:
    CaptureTransport(std::unique_ptr<link::Transport> inner, std::shared_ptr<Capture> capture)
        : TransportTap(std::move(inner)),
          capture_(std::move(capture)) {}

  private:
    void on_frame(link::Bytes& frame) override { read_frame(*capture_, frame); }

    void on_datagram(link::Bytes& datagram) override {
        read_datagram(*capture_, datagram.data(), datagram.size());
    }

    std::shared_ptr<Capture> capture_;
};

}  // namespace

std::unique_ptr<link::Transport> capture_transport(std::unique_ptr<link::Transport> inner,
                                                   std::shared_ptr<Capture> capture) {
    return std::make_unique<CaptureTransport>(std::move(inner), std::move(capture));
}

}  // namespace zoned::harness
