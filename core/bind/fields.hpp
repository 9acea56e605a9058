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

// A class that Python makes by the names of its fields; those that it does not name stay as they
// are.
template <typename T>
class Record : public nb::class_<T> {
  public:
    Record(nb::module_& module, const char* name, const char* doc)
        : nb::class_<T>(module, name, doc) {
        this->def(
            "__init__",
            [](nb::handle self, const nb::kwargs& fields) {
                new (nb::inst_ptr<T>(self)) T();
                nb::inst_mark_ready(self);
                for (const auto& [name, value] : fields) nb::setattr(self, name, value);
            },
            nb::sig("def __init__(self, **fields: object) -> None"));
        this->def("__reduce__", [names = names_](const nb::object& self) {
            nb::dict fields;
            for (const std::string& own : *names) fields[own.c_str()] = self.attr(own.c_str());
            const nb::object partial = nb::module_::import_("functools").attr("partial");
            return nb::make_tuple(partial(self.type(), **fields), nb::tuple());
        });
    }

    // Several, each after its name.
    template <typename Member, typename... Rest>
    Record& fields(const char* name, Member member, Rest... rest) {
        field(name, member);
        if constexpr (sizeof...(rest) > 0) fields(rest...);
        return *this;
    }
    template <typename V>
    Record& field(const char* name, V T::* member) {
        names_->push_back(name);
        this->def_rw(name, member);
        return *this;
    }
    // So many whole numbers.
    template <std::size_t count>
    Record& field(const char* name, int (T::*member)[count]) {
        names_->push_back(name);
        this->def_prop_rw(
            name,
            [member](const T& own) { return std::vector<int>(own.*member, own.*member + count); },
            [member, name](T& own, const std::vector<int>& given) {
                if (given.size() != count) throw nb::value_error(name);
                std::copy(given.begin(), given.end(), own.*member);
            });
        return *this;
    }
    // An array of any size.
    Record& array(const char* name, std::vector<double> T::* member) {
        names_->push_back(name);
        this->def_prop_rw(
            name, [member](const T& own) { return array_of(own.*member); },
            [member](T& own, const Array& given) {
                (own.*member).assign(given.data(), given.data() + given.size());
            },
            nb::for_getter(nb::rv_policy::move));
        return *this;
    }
    // An array of so many numbers.
    template <std::size_t count>
    Record& field(const char* name, double (T::*member)[count]) {
        names_->push_back(name);
        this->def_prop_rw(
            name,
            [member](const T& own) {
                return array_of(std::vector<double>(own.*member, own.*member + count));
            },
            [member, name](T& own, const Array& given) {
                const double* numbers = data_of(given, count, name);
                std::copy(numbers, numbers + count, own.*member);
            },
            nb::for_getter(nb::rv_policy::move));
        return *this;
    }

  private:
    std::shared_ptr<std::vector<std::string>> names_ = std::make_shared<std::vector<std::string>>();
};

}  // namespace impulsekit
