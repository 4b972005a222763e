#include "client-sim/link/tls_stream.h"

#include <openssl/ssl.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

namespace zoned::link {

TlsStream::TlsStream(asio::io_context& io,
                     asio::ssl::context& tls,
                     Trust trust,
                     StreamEvents events)
    : SocketStream(io, tls, std::move(trust), std::move(events), false),
      input_(16384) {
}

bool TlsStream::export_key(const char* label, wire::SealKey& key) {
    std::array<std::uint8_t, 28> material{};
    if (SSL_export_keying_material(stream_.native_handle(),
                                   material.data(),
                                   material.size(),
                                   label,
                                   std::strlen(label),
                                   nullptr,
                                   0,
                                   0) != 1) {
        return false;
    }
    std::copy_n(material.begin(), key.key.size(), key.key.begin());
    std::copy_n(material.begin() + key.key.size(), key.salt.size(), key.salt.begin());
    return true;
}

void TlsStream::on_open() {
    wire::SealKey down;
    wire::SealKey up;
    if (!export_key(wire::kExporterLabelDown, down) || !export_key(wire::kExporterLabelUp, up)) {
        fail("the TLS library exported no keys");
        return;
    }
    if (events_.opened) {
        events_.opened(down, up);
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

}  // namespace zoned::link
