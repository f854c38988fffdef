// Included before tests of DART: each of DART's detectors that a test names is oncollide's.
#pragma once
#include <cstdlib>

#include <dart/collision/bullet/bullet.hpp>
#include <dart/collision/dart/dart.hpp>
#include <dart/collision/fcl/fcl.hpp>
#include <dart/collision/ode/ode.hpp>
#include <dart/dart.hpp>

#include <oncollide/dart/detector.hpp>

namespace dart::collision {

template <int number>
class OncollideAsPeer : public OncollideCollisionDetector {
public:
    enum PrimitiveShape { PRIMITIVE, MESH };
    enum ContactPointComputationMethod { FCL, DART };
    using OncollideCollisionDetector::OncollideCollisionDetector;
    OncollideAsPeer() : OncollideCollisionDetector({.solidHeightmaps = number == 3}) {}
    static std::shared_ptr<OncollideAsPeer> create() { return std::make_shared<OncollideAsPeer>(); }
    static const std::string& getStaticType()
    {
        static const std::string names[] = {"dart", "fcl", "bullet", "ode"};
        return names[number];
    }
    const std::string& getType() const override ///< some tests look for one detector by its name
    {
        static const char* called = std::getenv("ONCOLLIDE_CALLED");
        static const std::string name = called ? called : "oncollide";
        return name;
    }
    void setPrimitiveShapeType(PrimitiveShape) {}
    PrimitiveShape getPrimitiveShapeType() const { return PRIMITIVE; }
    void setContactPointComputationMethod(ContactPointComputationMethod) {}
};
using OncollideAsDart = OncollideAsPeer<0>;
using OncollideAsFcl = OncollideAsPeer<1>;
using OncollideAsBullet = OncollideAsPeer<2>;
using OncollideAsOde = OncollideAsPeer<3>; // ODE's height maps are solid

/// The factory's keys make the same.
inline const bool registered = [] {
    CollisionDetector::Factory* factory = CollisionDetector::getFactory();
    factory->registerCreator("dart", [] { return OncollideAsDart::create(); });
    factory->registerCreator("fcl", [] { return OncollideAsFcl::create(); });
    factory->registerCreator("bullet", [] { return OncollideAsBullet::create(); });
    factory->registerCreator("ode", [] { return OncollideAsOde::create(); });
    return true;
}();

} // namespace dart::collision

#define DARTCollisionDetector OncollideAsDart
#define FCLCollisionDetector OncollideAsFcl
#define BulletCollisionDetector OncollideAsBullet
#define OdeCollisionDetector OncollideAsOde
