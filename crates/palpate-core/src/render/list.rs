//! List of methods: the only place to which a new method is added.

/// Passes the list to the macro `$make`, in the order of tables and figures. A line has
///
/// - the method: its name in [`AnyParams`](super::AnyParams) and [`AnyMethod`](super::AnyMethod), its parameters and
///   its checked type;
/// - if it has a memory between samples, a field of [`AnyMemory`](super::AnyMemory) and that field's type, or the field
///   of another method with the same memory;
/// - the names in programs, each with its description in the method's file.
///
/// [`Basic`](super::Basic), which has no parameters, comes before the list.
macro_rules! for_all_methods {
    ($make:ident) => {
        $make! {
            Seh(SehParams, Seh) remembers seh: SehMemory<S>, named Seh = seh::SEH;
            VirtualDamper(VirtualDamperParams<S>, VirtualDamper<S>) remembers device: PredictionMemory<S>, named VirtualDamper = virtual_damper::VIRTUAL_DAMPER;
            Popc(PopcParams<S>, Popc<S>), named Popc = popc::POPC;
            PopcRef(PopcRefParams<S>, PopcRef<S>), named PopcRef = popc_ref::POPC_REF;
            EnergyCorrected(EnergyCorrectedParams, EnergyCorrected) remembers energy_corrected: EnergyCorrectedMemory<S>, named EnergyCorrected = energy_corrected::ENERGY_CORRECTED;
            ForceBounding(ForceBoundingParams<S>, ForceBounding<S>) remembers force_bounding: ForceBoundingMemory<S>, named ForceBounding = force_bounding::FORCE_BOUNDING;
            Pmi(PmiParams, Pmi), named Pmi = pmi::PMI;
            EnergyTank(EnergyTankParams<S>, EnergyTank<S>), named EnergyTank = energy_tank::ENERGY_TANK;
            VirtualCoupling(VirtualCouplingParams<S>, VirtualCoupling<S>) remembers virtual_coupling: VirtualCouplingMemory<S>, named VirtualCoupling = virtual_coupling::VIRTUAL_COUPLING;
            Hfcr(HfcrParams<S>, Hfcr<S>) shares device, named HfcrMod = hfcr::HFCR_MOD, HfcrModSt = hfcr::HFCR_MOD_ST, Hfcr = hfcr::HFCR;
            Coupled(CoupledParams<S>, Coupled<S>) remembers coupled: CoupledMemory<S>, named Coupled = coupled::COUPLED;
        }
    };
}
pub(super) use for_all_methods;
