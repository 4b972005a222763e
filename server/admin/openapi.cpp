#include "server/admin/openapi.h"

#include "proto/admin.pb.h"
#include "shared/core/json.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/descriptor.pb.h>

#include <algorithm>
#include <map>
#include <memory>
#include <utility>

namespace zoned::admin {

namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;

constexpr const char* kDescriptionPath = "/api/v1/openapi.json";
constexpr const char* kPagePath = "/api";

void write_reference(core::JsonWriter& json, const Descriptor& message) {
    json.begin_object().field("$ref", "#/components/schemas/" + message.name()).end_object();
}

/// The type of one value of a field; JSON is protobuf's own mapping.
void write_type(core::JsonWriter& json, const FieldDescriptor& field) {
    switch (field.cpp_type()) {
        case FieldDescriptor::CPPTYPE_MESSAGE:
            write_reference(json, *field.message_type());
            return;
        case FieldDescriptor::CPPTYPE_BOOL:
            json.begin_object().field("type", "boolean").end_object();
            return;
        case FieldDescriptor::CPPTYPE_UINT32:
            json.begin_object().field("type", "integer").field("minimum", 0).end_object();
            return;
        case FieldDescriptor::CPPTYPE_DOUBLE:
            json.begin_object().field("type", "number").end_object();
            return;
        default:
            json.begin_object().field("type", "string").end_object();
            return;
    }
}

void write_field(core::JsonWriter& json, const FieldDescriptor& field) {
    json.key(field.name());
    if (field.is_map()) {
        json.begin_object().field("type", "object").key("additionalProperties");
        write_type(json, *field.message_type()->FindFieldByNumber(2));
        json.end_object();
    } else if (field.is_repeated()) {
        json.begin_object().field("type", "array").key("items");
        write_type(json, field);
        json.end_object();
    } else {
        write_type(json, field);
    }
}

void write_schema(core::JsonWriter& json, const Descriptor& message) {
    json.begin_object().field("type", "object").key("properties").begin_object();
    for (int f = 0; f < message.field_count(); ++f) {
        write_field(json, *message.field(f));
    }
    json.end_object().end_object();
}

/// A message and all that it holds, by name.
void collect(const Descriptor* message, std::map<std::string, const Descriptor*>& out) {
    if (message == nullptr ||
        (!message->options().map_entry() && !out.emplace(message->name(), message).second)) {
        return;
    }
    for (int f = 0; f < message->field_count(); ++f) {
        collect(message->field(f)->message_type(), out);
    }
}

void write_content(core::JsonWriter& json, const std::string& type, const Descriptor* message) {
    json.key("content").begin_object().key(type).begin_object().key("schema");
    if (message != nullptr) {
        write_reference(json, *message);
    } else {
        json.begin_object().field("type", "string").end_object();
    }
    json.end_object().end_object();
}

void write_parameters(core::JsonWriter& json, const AdminRoute& route) {
    json.key("parameters").begin_array();
    if (route.path.ends_with("{id}")) {
        json.begin_object()
            .field("name", "id")
            .field("in", "path")
            .field("required", true)
            .key("schema")
            .begin_object()
            .field("type", "integer")
            .field("minimum", 1)
            .end_object()
            .end_object();
    }
    for (const AdminQuery& query : route.doc.query) {
        json.begin_object()
            .field("name", query.name)
            .field("in", "query")
            .field("description", query.meaning)
            .key("schema")
            .begin_object()
            .field("type", "integer")
            .field("minimum", 0)
            .end_object()
            .end_object();
    }
    json.end_array();
}

void write_operation(core::JsonWriter& json, const AdminRoute& route) {
    std::string method = route.method;
    std::transform(method.begin(), method.end(), method.begin(), [](char c) {
        return static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
    });
    json.key(method).begin_object().field("summary", route.doc.summary);
    json.key("security").begin_array();
    if (!route.open) {
        json.begin_object().key("token").begin_array().end_array().end_object();
    }
    json.end_array();
    write_parameters(json, route);
    if (route.method == "POST") {
        json.key("requestBody").begin_object().field("required", route.doc.body != nullptr);
        write_content(json, "application/json", route.doc.body);
        json.end_object();
    }
    json.key("responses").begin_object();
    json.key("200").begin_object().field("description", "What was asked for");
    write_content(json, route.doc.answer_type, route.doc.answer);
    json.end_object();
    json.key("default").begin_object().field("description", "Why not (RFC 9457)");
    write_content(json, "application/problem+json", proto::admin::Problem::descriptor());
    json.end_object().end_object().end_object();
}

std::string escaped(const std::string& text) {
    std::string out;
    for (const char c : text) {
        out += c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '&' ? "&amp;" : std::string(1, c);
    }
    return out;
}

/// "account, hours, reason"; empty without a message.
std::string fields_of(const Descriptor* message) {
    std::string out;
    for (int f = 0; message != nullptr && f < message->field_count(); ++f) {
        out += (out.empty() ? "" : ", ") + message->field(f)->name();
    }
    return out;
}

AdminResponse text_response(const std::string& type, const std::string& text) {
    AdminResponse response;
    response.content_type = type;
    response.body = text;
    // The page has a style of its own, and nothing else.
    response.headers.emplace_back("Content-Security-Policy",
                                  "default-src 'none'; style-src 'unsafe-inline'; "
                                  "frame-ancestors 'none'");
    return response;
}

}  // namespace

std::string openapi_json(const std::vector<AdminRoute>& routes) {
    std::map<std::string, std::vector<const AdminRoute*>> by_path;
    std::map<std::string, const Descriptor*> schemas;
    collect(proto::admin::Problem::descriptor(), schemas);
    for (const AdminRoute& route : routes) {
        by_path[route.path].push_back(&route);
        collect(route.doc.body, schemas);
        collect(route.doc.answer, schemas);
    }
    core::JsonWriter json;
    json.begin_object().field("openapi", "3.0.3");
    json.key("info")
        .begin_object()
        .field("title", "zoned admin server")
        .field("version", "1")
        .field("description",
               "Requests that need a token send it as Authorization: Bearer TOKEN; it stands in "
               "admin.token of the server's state folder.")
        .end_object();
    json.key("paths").begin_object();
    for (const auto& [path, of_path] : by_path) {
        json.key(path).begin_object();
        for (const AdminRoute* route : of_path) {
            write_operation(json, *route);
        }
        json.end_object();
    }
    json.end_object();
    json.key("components").begin_object().key("schemas").begin_object();
    for (const auto& [name, message] : schemas) {
        json.key(name);
        write_schema(json, *message);
    }
    json.end_object();
    json.key("securitySchemes")
        .begin_object()
        .key("token")
        .begin_object()
        .field("type", "http")
        .field("scheme", "bearer")
        .end_object()
        .end_object()
        .end_object()
        .end_object();
    return json.text() + "\n";
}

std::string openapi_page(const std::vector<AdminRoute>& routes) {
    std::string rows;
    for (const AdminRoute& route : routes) {
        std::string query;
        for (const AdminQuery& one : route.doc.query) {
            query += (query.empty() ? "?" : "&") + one.name + "=";
        }
        rows += "<tr><td>" + route.method + "</td><td><code>" + escaped(route.path + query) +
                "</code></td><td>" + (route.open ? "no" : "yes") + "</td><td>" +
                escaped(route.doc.summary) + "</td><td>" + escaped(fields_of(route.doc.body)) +
                "</td><td>" + escaped(fields_of(route.doc.answer)) + "</td></tr>\n";
    }
    return "<!doctype html>\n<html lang=\"en\"><meta charset=\"utf-8\">"
           "<meta name=\"viewport\" content=\"width=device-width\">"
           "<title>zoned: admin interface</title>\n<style>:root{color-scheme:light dark}"
           "body{font:15px/1.5 system-ui,sans-serif;margin:2em}table{border-collapse:collapse}"
           "td,th{text-align:left;vertical-align:top;padding:.3em .8em;border-bottom:1px solid "
           "#8884}</style>\n<h1>Admin interface</h1>\n<p>Requests that need a token send it as "
           "<code>Authorization: Bearer TOKEN</code>; it stands in <code>admin.token</code> of "
           "the server's state folder. Bodies are JSON. Refusals are <code>application/problem"
           "+json</code> (RFC 9457). For programs: <a href=\"/api/v1/openapi.json\">openapi.json"
           "</a>.</p>\n<table><thead><tr><th>Method</th><th>Path</th><th>Token</th>"
           "<th>What it does</th><th>Body</th><th>Answer</th></tr></thead><tbody>\n" +
           rows + "</tbody></table></html>\n";
}

std::vector<AdminRoute> with_description(std::vector<AdminRoute> routes) {
    const auto json = std::make_shared<std::string>();
    const auto page = std::make_shared<std::string>();
    AdminRoute description{"GET",
                           kDescriptionPath,
                           true,
                           [json](const AdminCall&, const AdminReply& reply) {
                               reply(text_response("application/json", *json));
                           },
                           {}};
    description.doc.summary = "This interface, for programs (OpenAPI 3.0.3)";
    AdminRoute for_people{"GET",
                          kPagePath,
                          true,
                          [page](const AdminCall&, const AdminReply& reply) {
                              reply(text_response("text/html; charset=utf-8", *page));
                          },
                          {}};
    for_people.doc.summary = "This interface, for people";
    for_people.doc.answer_type = "text/html";
    routes.push_back(std::move(description));
    routes.push_back(std::move(for_people));
    *json = openapi_json(routes);
    *page = openapi_page(routes);
    return routes;
}

}  // namespace zoned::admin
