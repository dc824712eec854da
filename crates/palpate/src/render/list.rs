//! The list of methods: the one place that a new method is added to.

/// Hands the list to the macro `$make`, in the order of tables and figures. A line has
///
/// - the method: its name in [`AnyParams`](super::AnyParams) and
///   [`AnyMethod`](super::AnyMethod), its parameters and its checked type;
/// - where it remembers something between samples, a field of [`AnyMemory`](super::AnyMemory) and that
///   field's type, or the field of another method whose memory it goes on with;
/// - the names under which programs offer it, each with what the method's own file says of it.
///
/// [`Basic`](super::Basic), which has no parameters, comes before the list.
macro_rules! for_all_methods {
    ($make:ident) => {
        $make! {
            Seh(SehParams, Seh) remembers seh: SehMemory<S>, named Seh = seh::SEH;
            VirtualDamper(VirtualDamperParams<S>, VirtualDamper<S>) remembers device: PredictionMemory<S>, named VirtualDamper = virtual_damper::VIRTUAL_DAMPER;
            Popc(PopcParams<S>, Popc<S>), named Popc = popc::POPC;
            PopcRef(PopcRefParams<S>, PopcRef<S>), named PopcRef = popc_ref::POPC_REF;
            Hfcr(HfcrParams<S>, Hfcr<S>) shares device, named HfcrMod = hfcr::HFCR_MOD, HfcrModSt = hfcr::HFCR_MOD_ST, Hfcr = hfcr::HFCR;
            Coupled(CoupledParams<S>, Coupled<S>) remembers coupled: CoupledMemory<S>, named Coupled = coupled::COUPLED;
        }
    };
}
pub(super) use for_all_methods;
