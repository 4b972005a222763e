// Frames over TLS 1.3: a 4-byte little-endian length, then one message.
#include "client-sim/link/frame_stream.h"

#include <algorithm>
#include <utility>

namespace zoned::link {

namespace {

class TlsStream final : public SocketStream {
  public:
    TlsStream(const StreamWorld& world, Trust trust, StreamEvents events)
        : SocketStream(world, std::move(trust), std::move(events), false),
          input_(16384) {}

    void send_frame(const Bytes& frame) override;

  private:
    void on_open() override;
    std::span<std::uint8_t> room() override;
    void on_bytes(std::size_t size_read) override;

    std::vector<std::uint8_t> input_;
    std::size_t input_used_ = 0;
};

void TlsStream::on_open() {
    if (events_.opened) {
        events_.opened(false);
    }
}

std::span<std::uint8_t> TlsStream::room() {
    if (input_used_ == input_.size()) {
        input_.resize(std::min(input_.size() * 2, kMostFrameBytes + 4));
    }
    return std::span(input_).subspan(input_used_);
}

void TlsStream::on_bytes(std::size_t size_read) {
    input_used_ += size_read;
    std::size_t at = 0;
    while (input_used_ - at >= 4) {
        const std::uint8_t* head = input_.data() + at;
        const std::size_t size =
            static_cast<std::size_t>(head[0]) | static_cast<std::size_t>(head[1]) << 8 |
            static_cast<std::size_t>(head[2]) << 16 | static_cast<std::size_t>(head[3]) << 24;
        if (size > kMostFrameBytes) {
            fail("the server sent a frame of " + std::to_string(size) + " bytes");
            return;
        }
        if (input_used_ - at - 4 < size) {
            break;
        }
        if (events_.frame) {
            events_.frame(Bytes(head + 4, head + 4 + size));
        }
        at += 4 + size;
    }
    std::copy(input_.begin() + static_cast<std::ptrdiff_t>(at),
              input_.begin() + static_cast<std::ptrdiff_t>(input_used_),
              input_.begin());
    input_used_ -= at;
}

void TlsStream::send_frame(const Bytes& frame) {
    if (done()) {
        return;
    }
    const auto size = static_cast<std::uint32_t>(frame.size());
    for (int shift = 0; shift < 32; shift += 8) {
        pending_.push_back(static_cast<std::uint8_t>(size >> shift));
    }
    pending_.insert(pending_.end(), frame.begin(), frame.end());
    write();
}

}  // namespace

std::shared_ptr<FrameStream> make_tls_stream(const StreamWorld& world,
                                             const Trust& trust,
                                             StreamEvents events) {
    return std::make_shared<TlsStream>(world, trust, std::move(events));
}

}  // namespace zoned::link
