#include "server/admin/admin_request.h"

#include "shared/core/json.h"

namespace zoned::admin {

const char* status_phrase(unsigned status) {
    switch (status) {
        case 101:
            return "Switching Protocols";
        case 200:
            return "OK";
        case 400:
            return "Bad Request";
        case 401:
            return "Unauthorized";
        case 403:
            return "Forbidden";
        case 404:
            return "Not Found";
        case 405:
            return "Method Not Allowed";
        case 409:
            return "Conflict";
        case 413:
            return "Content Too Large";
        case 414:
            return "URI Too Long";
        case 415:
            return "Unsupported Media Type";
        case 421:
            return "Misdirected Request";
        case 426:
            return "Upgrade Required";
        case 429:
            return "Too Many Requests";
        case 431:
            return "Request Header Fields Too Large";
        case 503:
            return "Service Unavailable";
        case 504:
            return "Gateway Timeout";
        default:
            return "Internal Server Error";
    }
}

AdminResponse problem(unsigned status, const std::string& detail) {
    core::JsonWriter json;
    json.begin_object()
        .field("type", "about:blank")
        .field("title", status_phrase(status))
        .field("status", status)
        .field("detail", detail)
        .end_object();
    AdminResponse response;
    response.status = status;
    response.content_type = "application/problem+json";
    response.body = json.text() + "\n";
    return response;
}

}  // namespace zoned::admin
