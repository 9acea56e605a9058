// Classes of named fields: what Python gives the core, and what it reads of results.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#include "bind/arrays.hpp"

namespace impulsekit {

template <typename T>
struct IsArray : std::false_type {};
template <>
struct IsArray<std::vector<double>> : std::true_type {};
template <>
struct IsArray<std::vector<char>> : std::true_type {};
template <>
struct IsArray<std::vector<std::int8_t>> : std::true_type {};

template <typename E, typename... Rest>
void add_values(nb::enum_<E>& to, const char* name, E value, Rest... rest) {
    to.value(name, value);
    if constexpr (sizeof...(rest) > 0) add_values(to, rest...);
}

// An enumeration: its values, each after its name.
template <typename E, typename... Values>
void bind_enum(nb::module_& module, const char* name, Values... values) {
    nb::enum_<E> own(module, name, nb::is_arithmetic());
    add_values(own, values...);
}

// A class that Python reads.
template <typename T>
class Result : public nb::class_<T> {
  public:
    using nb::class_<T>::class_;

    // A member, or what a function finds; numbers and flags as arrays.
    template <typename Part>
    Result& part(const char* name, Part part) {
        using Found = std::decay_t<std::invoke_result_t<Part, const T&>>;
        if constexpr (IsArray<Found>::value)
            this->def_prop_ro(
                name, [part](const T& own) { return array_of(std::invoke(part, own)); },
                nb::rv_policy::move);
        else if constexpr (std::is_member_object_pointer_v<Part>)
            this->def_ro(name, part);
        else
            this->def_prop_ro(name, part);
        return *this;
    }
    // Several, each after its name.
    template <typename Part, typename... Rest>
    Result& parts(const char* name, Part one, Rest... rest) {
        part(name, one);
        if constexpr (sizeof...(rest) > 0) parts(rest...);
        return *this;
    }
};

// The name of a type in a signature.
template <typename V>
constexpr const char* hint_of() {
    return std::is_same_v<V, double> ? "float"
           : std::is_same_v<V, int>  ? "int"
           : std::is_same_v<V, bool> ? "bool"
                                     : "object";
}

// A class that Python makes by the names of its fields; those that it does not name stay as they
// are. Its constructor and its pickling are defined when all fields are known.
template <typename T>
class Record : public nb::class_<T> {
  public:
    using nb::class_<T>::class_;
    Record(const Record&) = delete;
    Record& operator=(const Record&) = delete;

    ~Record() {
        this->def(
            "__init__",
            [](nb::handle self, const nb::kwargs& fields) {
                new (nb::inst_ptr<T>(self)) T();
                nb::inst_mark_ready(self);
                for (const auto& [name, value] : fields) nb::setattr(self, name, value);
            },
            nb::sig((signature_ + ") -> None").c_str()));
        this->def("__reduce__", [names = names_](const nb::object& self) {
            nb::dict fields;
            for (const std::string& own : names) fields[own.c_str()] = self.attr(own.c_str());
            const nb::object partial = nb::module_::import_("functools").attr("partial");
            return nb::make_tuple(partial(self.type(), **fields), nb::tuple());
        });
    }

    // A field that is read and written by functions.
    template <typename Get, typename Set, typename... Extra>
    Record& custom(const char* name, Get get, Set set, const Extra&... extra) {
        add_name(name, "object");
        this->def_prop_rw(name, get, set, nb::for_getter(nb::rv_policy::move), extra...);
        return *this;
    }
    // Several, each after its name.
    template <typename Member, typename... Rest>
    Record& fields(const char* name, Member member, Rest... rest) {
        field(name, member);
        if constexpr (sizeof...(rest) > 0) fields(rest...);
        return *this;
    }
    template <typename V, typename C>
    Record& field(const char* name, V C::* member) {
        add_name(name, hint_of<V>());
        this->def_rw(name, member);
        return *this;
    }
    // So many whole numbers.
    template <std::size_t count, typename C>
    Record& field(const char* name, int (C::*member)[count]) {
        return custom(
            name,
            [member](const T& own) { return std::vector<int>(own.*member, own.*member + count); },
            [member, name](T& own, const std::vector<int>& given) {
                if (given.size() != count) throw nb::value_error(name);
                std::copy(given.begin(), given.end(), own.*member);
            });
    }
    // An array of any size.
    Record& array(const char* name, std::vector<double> T::* member) {
        return custom(
            name, [member](const T& own) { return array_of(own.*member); },
            [member](T& own, const Array& given) {
                (own.*member).assign(given.data(), given.data() + given.size());
            });
    }
    // An array of so many numbers.
    template <std::size_t count, typename C>
    Record& field(const char* name, double (C::*member)[count]) {
        return custom(
            name,
            [member](const T& own) {
                return array_of(std::vector<double>(own.*member, own.*member + count));
            },
            [member, name](T& own, const Array& given) {
                const double* numbers = data_of(given, count, name);
                std::copy(numbers, numbers + count, own.*member);
            });
    }

  private:
    void add_name(const char* name, const char* hint) {
        signature_ += std::string(names_.empty() ? ", *, " : ", ") + name + ": " + hint + " = ...";
        names_.push_back(name);
    }

    std::vector<std::string> names_;
    std::string signature_ = "def __init__(self";
};

}  // namespace impulsekit
