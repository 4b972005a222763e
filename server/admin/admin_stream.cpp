#include "server/admin/admin_stream.h"

namespace zoned::admin {

void AdminStream::start_read(boost::asio::mutable_buffer buffer, Waiting waiting) {
    if (inner_->tls) {
        inner_->tls->async_read_some(buffer, std::move(waiting));
    } else {
        inner_->tcp.async_read_some(buffer, std::move(waiting));
    }
}

void AdminStream::start_write(const Gathered& buffers, Waiting waiting) {
    if (inner_->tls) {
        inner_->tls->async_write_some(buffers, std::move(waiting));
    } else {
        inner_->tcp.async_write_some(buffers, std::move(waiting));
    }
}

}  // namespace zoned::admin
